// procgen-gallery: contact sheets of the games, as agents and as people see them, and of their
// sprites. Writes single pictures and a list of sheets, then becomes deploy/mosaic.py, which draws
// the sheets. README.md beside this file says what is on them.

#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/shared_art.h"
#include "envcore/render/game_art.h"
#include "envcore/render/rasteriser.h"
#include "envcore/scene/scene.h"
#include "nlohmann/json.hpp"
#include "tests/pictures/images.h"
#include "tests/pictures/played_level.h"
#include "tests/pictures/requests.h"
#include "tests/pictures/sprite_card.h"
#include "tests/play/progress.h"

ABSL_FLAG(std::vector<std::string>, games, {}, "games to draw, e.g. maze,heist; empty: all");
ABSL_FLAG(std::string, art, "", "folder of art in the released layout; empty: the built-in art");

namespace procgen {
namespace {

constexpr int32_t kLevelCount = 8;  // of each mode, on a game's sheet
// On the overview: levels whose backgrounds differ.
constexpr int32_t kOverviewLevelCount = 3;
constexpr int32_t kOverviewFirstEasyLevel = 5;
constexpr int32_t kOverviewFirstHardLevel = 2;
constexpr int32_t kOverviewPageWidthPx = 900;
constexpr int32_t kHumanViewSidePx = 512;
constexpr int32_t kShownSidePx = 256;  // of every view on a sheet

// Writes the pictures of the sheets, and keeps account of what is on which.
class Gallery {
 public:
  Gallery(std::string folder, const SharedArt& art) : folder_(std::move(folder)), art_(art) {}

  // The sheet of a game's levels, its row on the overview, and the sheet of its sprites.
  // `show` is told how many of how many pieces of work are done.
  absl::Status AddGame(const GameFacts& facts, absl::FunctionRef<void(int64_t, int64_t)> show);
  // The sheet of the sprites that all games share, drawn with the art of one of them.
  absl::Status AddSharedSprites(const GameFacts& facts);

  // All sheets, as mosaic.py reads them.
  nlohmann::json Sheets() const;

 private:
  using Json = nlohmann::json;

  absl::Status AddLevel(const GameFacts& facts, DistributionMode mode, int32_t level,
                        Json* agent_views, Json* human_views);
  // The sheet NAME_sprites.png.
  absl::Status AddSprites(const std::string& name, absl::Span<const ArtSlot> slots,
                          const GameArt& art);
  // Writes a picture and gives its entry of a sheet.
  absl::Status Write(const Image& image, const std::string& name, const std::string& caption,
                     Json* entries);

  const std::string folder_;
  const SharedArt& art_;
  Rasteriser rasteriser_;
  Json sheets_ = Json::array();
  Json overview_ = Json::array();  // rows
};

const GameArtFacts& ArtFactsOf(const GameFacts& facts) {
  return facts.make(GameOptions())->art();  // a table of the game's file, that stays
}

bool IsOnOverview(DistributionMode mode, int32_t level) {
  const auto follows = [level](int32_t first) {
    return level >= first && level < first + kOverviewLevelCount;
  };
  return (mode == DistributionMode::kEasy && follows(kOverviewFirstEasyLevel)) ||
         (mode == DistributionMode::kHard && follows(kOverviewFirstHardLevel));
}

// A view as an image. `rgb`: uint8 [side_px, side_px, 3].
Image ImageOf(absl::Span<const uint8_t> rgb, int side_px) {
  Image image(side_px, side_px);
  const uint8_t* from = rgb.data();
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x, from += 3) {
      image.At(x, y) = {from[0], from[1], from[2], 255};
    }
  }
  return image;
}

nlohmann::json Row(const std::string& name, const std::string& description,
                   nlohmann::json pictures) {
  return {{"name", name}, {"description", description}, {"pictures", std::move(pictures)}};
}

absl::Status Gallery::Write(const Image& image, const std::string& name, const std::string& caption,
                            Json* entries) {
  const std::string file = absl::StrCat("pictures/", name, ".png");
  entries->push_back({{"file", file}, {"caption", caption}});
  return WritePng(image, absl::StrCat(folder_, "/", file));
}

absl::Status Gallery::AddLevel(const GameFacts& facts, DistributionMode mode, int32_t level,
                               Json* agent_views, Json* human_views) {
  const std::unique_ptr<Game> game = PlayedLevel(facts, mode, level);
  const auto art = art_.Of(facts, game->art());
  Scene scene;
  game->FillScene(&scene);
  const std::string name = absl::StrCat(facts.name, "_", DistributionModeName(mode), "_", level);
  const std::string caption = absl::StrCat("level ", level);
  std::vector<uint8_t> view(size_t{kAgentViewSidePx} * kAgentViewSidePx * 3);
  rasteriser_.DrawAgentView(scene, *art, nullptr, absl::MakeSpan(view));
  if (absl::Status status = Write(ImageOf(view, kAgentViewSidePx), absl::StrCat(name, "_agent"),
                                  caption, agent_views);
      !status.ok()) {
    return status;
  }
  view.resize(size_t{kHumanViewSidePx} * kHumanViewSidePx * 3);
  rasteriser_.DrawHumanView(scene, *art, kHumanViewSidePx, absl::MakeSpan(view));
  return Write(ImageOf(view, kHumanViewSidePx), absl::StrCat(name, "_human"), caption, human_views);
}

absl::Status Gallery::AddSprites(const std::string& name, absl::Span<const ArtSlot> slots,
                                 const GameArt& art) {
  Json rows = Json::array();
  for (const ArtSlot& slot : slots) {
    if (rows.empty() || slot.theme == 0) {
      rows.push_back(
          Row(std::string(slot.name), absl::StrCat("image kind ", slot.kind), Json::array()));
    }
    const Picture& picture = *art.SpriteOf(slot.kind, slot.theme, false).picture;
    const std::string caption = absl::StrCat(slot.name, "_", slot.theme);
    if (absl::Status status =
            Write(SpriteCard(picture), absl::StrCat(name, "_", slot.kind, "_", caption), caption,
                  &rows.back()["pictures"]);
        !status.ok()) {
      return status;
    }
  }
  sheets_.push_back({{"file", absl::StrCat(name, "_sprites.png")}, {"rows", std::move(rows)}});
  return absl::OkStatus();
}

absl::Status Gallery::AddGame(const GameFacts& facts,
                              absl::FunctionRef<void(int64_t, int64_t)> show) {
  const std::string name(facts.name);
  const auto total = static_cast<int64_t>(facts.modes.size()) * kLevelCount + 1;
  int64_t done = 0;
  Json rows = Json::array();
  Json overview = Json::array();
  for (const DistributionMode mode : facts.modes) {
    Json agent_views = Json::array();
    Json human_views = Json::array();
    for (int32_t level = 0; level < kLevelCount; ++level) {
      if (absl::Status status = AddLevel(facts, mode, level, &agent_views, &human_views);
          !status.ok()) {
        return status;
      }
      if (IsOnOverview(mode, level)) {
        overview.push_back({{"file", human_views.back()["file"]}});
      }
      show(++done, total);
    }
    const std::string mode_name(DistributionModeName(mode));
    rows.push_back(Row(mode_name, "as people see it", std::move(human_views)));
    rows.push_back(Row(mode_name, "as an agent sees it", std::move(agent_views)));
  }
  sheets_.push_back(
      {{"file", absl::StrCat(name, ".png")}, {"side_px", kShownSidePx}, {"rows", std::move(rows)}});
  overview_.push_back(Row(name, std::string(facts.description), std::move(overview)));
  const GameArtFacts& art = ArtFactsOf(facts);
  absl::Status status = AddSprites(name, art.slots, *art_.Of(facts, art));
  show(total, total);
  return status;
}

absl::Status Gallery::AddSharedSprites(const GameFacts& facts) {
  return AddSprites("shared", SharedArtSlots(), *art_.Of(facts, ArtFactsOf(facts)));
}

nlohmann::json Gallery::Sheets() const {
  Json sheets = sheets_;
  sheets.push_back({{"file", "games.png"},
                    {"side_px", kShownSidePx},
                    {"page_width_px", kOverviewPageWidthPx},
                    {"rows", overview_}});
  return sheets;
}

int Fail(absl::string_view error) {
  std::cerr << "procgen-gallery: " << error << "\n";
  return 2;
}

int Main(const std::vector<char*>& arguments) {
  if (arguments.size() != 2) {
    return Fail(absl::StrCat("there are ", arguments.size() - 1,
                             " arguments beside the flags, it is one: the folder to draw into"));
  }
  const std::string folder = arguments[1];
  const auto games = FindGames(absl::GetFlag(FLAGS_games));
  if (!games.ok()) {
    return Fail(games.status().message());
  }
  const auto art = OpenArt(absl::GetFlag(FLAGS_art));
  if (!art.ok()) {
    return Fail(art.status().message());
  }
  if (absl::Status status = MakeFolder(absl::StrCat(folder, "/pictures")); !status.ok()) {
    return Fail(status.message());
  }
  Gallery gallery(folder, **art);
  Progress progress(games->size());
  for (const GameFacts* game : *games) {
    absl::Status status = gallery.AddGame(
        *game, [&](int64_t done, int64_t total) { progress.Show(game->name, done, total); });
    if (!status.ok()) {
      return Fail(status.message());
    }
    progress.Finish(game->name, "drawn");
  }
  if (absl::Status status = gallery.AddSharedSprites(*games->front()); !status.ok()) {
    return Fail(status.message());
  }
  const std::string list = absl::StrCat(folder, "/sheets.json");
  if (!(std::ofstream(list) << gallery.Sheets().dump(1) << std::flush)) {
    return Fail(absl::StrCat("cannot write ", list));
  }
  execl(PROCGEN_PYTHON, PROCGEN_PYTHON, PROCGEN_MOSAIC, list.c_str(), nullptr);
  return Fail(absl::StrCat("cannot run ", PROCGEN_PYTHON, ": ", std::strerror(errno)));
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Draws contact sheets of the games and of their sprites into a folder.\n"
      "usage: procgen-gallery OUT_FOLDER [--games NAME,...] [--art FOLDER]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
