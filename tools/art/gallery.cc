#include "tools/art/gallery.h"

#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/games/game.h"
#include "envcore/scene/scene.h"
#include "png.h"
#include "tools/art/played_level.h"
#include "tools/art/sprite_sheet.h"

namespace procgen {
namespace {

constexpr int32_t kLevelCount = 8;  // per mode, on a game's sheet
// Levels on the overview, chosen for different backgrounds.
constexpr int32_t kOverviewLevelCount = 3;
constexpr int32_t kOverviewFirstEasyLevel = 5;
constexpr int32_t kOverviewFirstHardLevel = 2;
constexpr int32_t kOverviewPageWidthPx = 900;
constexpr int32_t kHumanViewSizePx = 512;
constexpr int32_t kShownSizePx = 256;  // of every view on a sheet

const GameArtSpec& ArtSpecOf(const GameSpec& spec) {
  return spec.make(GameOptions())->art();  // a constant table in the game's file
}

bool IsOnOverview(DistributionMode mode, int32_t level) {
  const auto follows = [level](int32_t first) {
    return level >= first && level < first + kOverviewLevelCount;
  };
  return (mode == DistributionMode::kEasy && follows(kOverviewFirstEasyLevel)) ||
         (mode == DistributionMode::kHard && follows(kOverviewFirstHardLevel));
}

// Converts a view, uint8 [size_px, size_px, 3], to an image.
Image ImageOf(absl::Span<const uint8_t> rgb, int size_px) {
  Image image(size_px, size_px);
  const uint8_t* from = rgb.data();
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x, from += 3) {
      image.At(x, y) = {from[0], from[1], from[2], 255};
    }
  }
  return image;
}

// Writes an image of opaque pixels.
absl::Status WritePng(const Image& image, const std::string& path) {
  png_image file = {};
  file.version = PNG_IMAGE_VERSION;
  file.width = static_cast<png_uint_32>(image.width());
  file.height = static_cast<png_uint_32>(image.height());
  file.format = PNG_FORMAT_RGBA;
  if (png_image_write_to_file(&file, path.c_str(), 0, image.Row(0), 0, nullptr) == 0) {
    return absl::InvalidArgumentError(absl::StrCat("cannot write ", path, ": ", file.message));
  }
  return absl::OkStatus();
}

nlohmann::json Row(const std::string& name, const std::string& description,
                   nlohmann::json pictures) {
  return {{"name", name}, {"description", description}, {"pictures", std::move(pictures)}};
}

}  // namespace

Gallery::Gallery(std::string folder, const SharedArt& art)
    : folder_(std::move(folder)), art_(art), sheets_(Json::array()), overview_(Json::array()) {}

absl::Status Gallery::Write(const Image& image, const std::string& name, const std::string& caption,
                            Json* entries) {
  const std::string file = absl::StrCat("pictures/", name, ".png");
  entries->push_back({{"file", file}, {"caption", caption}});
  return WritePng(image, absl::StrCat(folder_, "/", file));
}

absl::Status Gallery::AddLevel(const GameSpec& spec, DistributionMode mode, int32_t level,
                               Json* agent_views, Json* human_views) {
  const std::unique_ptr<Game> game = PlayedLevel(spec, mode, level);
  const auto art = art_.Of(spec, game->art());
  Scene scene;
  game->FillScene(&scene);
  const std::string name = absl::StrCat(spec.name, "_", DistributionModeName(mode), "_", level);
  const std::string caption = absl::StrCat("level ", level);
  std::vector<uint8_t> view(kUpstreamFrameFormat.bytes());
  rasteriser_.DrawAgentView(scene, *art, nullptr, kUpstreamFrameFormat, absl::MakeSpan(view));
  if (absl::Status status = Write(ImageOf(view, kUpstreamFrameFormat.size_px),
                                  absl::StrCat(name, "_agent"), caption, agent_views);
      !status.ok()) {
    return status;
  }
  view.resize(size_t{kHumanViewSizePx} * kHumanViewSizePx * 3);
  rasteriser_.DrawHumanView(scene, *art, kHumanViewSizePx, absl::MakeSpan(view));
  return Write(ImageOf(view, kHumanViewSizePx), absl::StrCat(name, "_human"), caption, human_views);
}

absl::Status Gallery::AddSprites(const std::string& name, absl::Span<const ArtSlot> slots,
                                 const GameArt& art) {
  Json rows = Json::array();
  for (const ArtSlot& slot : slots) {
    if (rows.empty() || slot.theme == 0) {
      rows.push_back(
          Row(std::string(slot.name), absl::StrCat("image kind ", slot.kind), Json::array()));
    }
    const MipmappedImage& picture = *art.SpriteOf(slot.kind, slot.theme, false).picture;
    const std::string caption = absl::StrCat(slot.name, "_", slot.theme);
    if (absl::Status status =
            Write(SpriteSheet(picture), absl::StrCat(name, "_", slot.kind, "_", caption), caption,
                  &rows.back()["pictures"]);
        !status.ok()) {
      return status;
    }
  }
  sheets_.push_back({{"file", absl::StrCat(name, "_sprites.png")}, {"rows", std::move(rows)}});
  return absl::OkStatus();
}

absl::Status Gallery::AddGame(const GameSpec& spec) {
  const std::string name(spec.name);
  Json rows = Json::array();
  Json overview = Json::array();
  for (const DistributionMode mode : spec.modes) {
    Json agent_views = Json::array();
    Json human_views = Json::array();
    for (int32_t level = 0; level < kLevelCount; ++level) {
      if (absl::Status status = AddLevel(spec, mode, level, &agent_views, &human_views);
          !status.ok()) {
        return status;
      }
      if (IsOnOverview(mode, level)) {
        overview.push_back({{"file", human_views.back()["file"]}});
      }
    }
    const std::string mode_name(DistributionModeName(mode));
    rows.push_back(Row(mode_name, "as people see it", std::move(human_views)));
    rows.push_back(Row(mode_name, "as an agent sees it", std::move(agent_views)));
  }
  sheets_.push_back(
      {{"file", absl::StrCat(name, ".png")}, {"size_px", kShownSizePx}, {"rows", std::move(rows)}});
  overview_.push_back(Row(name, std::string(spec.description), std::move(overview)));
  const GameArtSpec& art = ArtSpecOf(spec);
  return AddSprites(name, art.slots, *art_.Of(spec, art));
}

absl::Status Gallery::AddSharedSprites(const GameSpec& spec) {
  return AddSprites("shared", SharedArtSlots(), *art_.Of(spec, ArtSpecOf(spec)));
}

std::string Gallery::SheetList() const {
  Json sheets = sheets_;
  sheets.push_back({{"file", "games.png"},
                    {"size_px", kShownSizePx},
                    {"page_width_px", kOverviewPageWidthPx},
                    {"rows", overview_}});
  return sheets.dump(1);
}

}  // namespace procgen
