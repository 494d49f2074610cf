// procgen-legibility: measures whether the parts of a game can be distinguished at the size that an
// agent sees, and compares the contrast of two arts. See README.md.

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "envcore/pool/shared_art.h"
#include "tools/art/contrast.h"
#include "tools/art/images.h"
#include "tools/art/legibility.h"
#include "tools/art/requests.h"
#include "tools/art/variety.h"
#include "tools/progress.h"

ABSL_FLAG(std::vector<std::string>, games, {}, "games to measure, e.g. maze,heist; empty: all");
ABSL_FLAG(std::string, art_dir, "",
          "folder with art in the layout of Procgen 0.10.7; empty: the built-in art");
ABSL_FLAG(
    std::string, contrast_to, "",
    "folder with art in the layout of Procgen 0.10.7: compare the contrast of the agent's views "
    "with it, instead of measuring distances");
ABSL_FLAG(
    int32_t, variety_levels, 0,
    "with --contrast_to: compare how much the first views of this many levels differ, instead "
    "of the contrast; at least 0");
ABSL_FLAG(double, minimum, 0,
          "smallest distance that passes, or with --contrast_to smallest ratio; at least 0");
ABSL_FLAG(std::string, crops, "", "folder for an enlarged image of each pair; empty: none");

namespace procgen {
namespace {

constexpr int kCropFactor = 10;
constexpr int kCropGapPx = 10;

int Fail(absl::string_view error) {
  std::cerr << "procgen-legibility: " << error << "\n";
  return 2;
}

absl::string_view SecondName(const PartDistance& likeness) {
  return likeness.second == nullptr ? "the backdrop" : likeness.second->name;
}

absl::string_view SecondRole(const PartDistance& likeness) {
  return likeness.second == nullptr ? "backdrop" : RoleName(likeness.second->role);
}

std::string AppearanceName(const Part* part, const Appearance& appearance) {
  if (part == nullptr || appearance.image_kind == kDotImage) {
    return "–";
  }
  return absl::StrCat(appearance.image_kind, ".", appearance.theme);
}

// Writes the two windows side by side, enlarged.
absl::Status WriteCrop(const PartDistance& likeness, const std::string& path) {
  constexpr int kSizePx = kWindowSizePx * kCropFactor;
  Image crop(2 * kSizePx + kCropGapPx, kSizePx);
  int left = 0;
  for (const Window* window : {&likeness.first_window, &likeness.second_window}) {
    Image image(kWindowSizePx, kWindowSizePx);
    std::copy(window->begin(), window->end(), image.Row(0));
    Paste(Enlarged(image, kCropFactor), left, 0, &crop);
    left += kSizePx + kCropGapPx;
  }
  return WritePng(crop, path);
}

absl::Status WriteCrops(const Roles& roles, const std::vector<PartDistance>& likenesses) {
  const std::string folder = absl::GetFlag(FLAGS_crops);
  if (folder.empty()) {
    return absl::OkStatus();
  }
  if (absl::Status status = MakeFolder(folder); !status.ok()) {
    return status;
  }
  for (const PartDistance& likeness : likenesses) {
    const std::string name = absl::StrReplaceAll(
        absl::StrCat(roles.game, "_", likeness.first->name, "_", SecondName(likeness)),
        {{" ", "-"}, {"'", ""}});
    if (absl::Status status = WriteCrop(likeness, absl::StrCat(folder, "/", name, ".png"));
        !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

// Prints the table of a game, with the closest pair in bold.
void PrintTable(const Roles& roles, const std::vector<PartDistance>& likenesses) {
  std::cout << "\n## " << roles.game
            << "\n\n| distance | part | role | compared with | role | shows | shows | on |\n"
               "| --- | --- | --- | --- | --- | --- | --- | --- |\n";
  bool least = true;
  for (const PartDistance& likeness : likenesses) {
    const std::string distance = absl::StrFormat("%.1f", likeness.distance);
    std::cout << "| " << (least ? absl::StrCat("**", distance, "**") : distance) << " | "
              << likeness.first->name << " | " << RoleName(likeness.first->role) << " | "
              << SecondName(likeness) << " | " << SecondRole(likeness) << " | "
              << AppearanceName(likeness.first, likeness.first_appearance) << " | "
              << AppearanceName(likeness.second, likeness.second_appearance) << " | "
              << likeness.backdrop << " |\n";
    least = false;
  }
}

int64_t WeakCount(const std::vector<PartDistance>& likenesses) {
  return std::count_if(likenesses.begin(), likenesses.end(), [](const PartDistance& likeness) {
    return likeness.distance < absl::GetFlag(FLAGS_minimum);
  });
}

// Returns an error in the command line; empty: none.
std::string CommandError(const std::vector<char*>& arguments) {
  if (arguments.size() > 1) {
    return absl::StrCat("unexpected argument '", arguments[1], "': only flags are allowed");
  }
  if (!(absl::GetFlag(FLAGS_minimum) >= 0)) {
    return absl::StrCat("--minimum ", absl::GetFlag(FLAGS_minimum), ": must be at least 0");
  }
  const int32_t level_count = absl::GetFlag(FLAGS_variety_levels);
  if (level_count < 0 || (level_count > 0 && absl::GetFlag(FLAGS_contrast_to).empty())) {
    return absl::StrCat("--variety_levels ", level_count,
                        ": must be at least 0, and needs --contrast_to");
  }
  return "";
}

// Returns the exit status.
int ReportWeak(int64_t count, absl::string_view things) {
  if (count > 0) {
    std::cerr << count << " " << things << " are below " << absl::GetFlag(FLAGS_minimum) << "\n";
  }
  return count > 0 ? 1 : 0;
}

int MeasureDistances(const DrawingRequest& request) {
  Progress progress(request.games.size());
  int64_t weak_count = 0;
  for (const GameSpec* game : request.games) {
    const Roles& roles = RolesOf(game->name);
    const std::vector<PartDistance> likenesses =
        CompareParts(roles, *request.art,
                     [&](int64_t done, int64_t total) { progress.Show(roles.game, done, total); });
    progress.Finish(roles.game, absl::StrFormat("%.1f", likenesses.front().distance));
    PrintTable(roles, likenesses);
    if (absl::Status status = WriteCrops(roles, likenesses); !status.ok()) {
      return Fail(status.message());
    }
    weak_count += WeakCount(likenesses);
  }
  return ReportWeak(weak_count, "pairs");
}

void PrintContrasts(absl::string_view name, const Contrast& art, const Contrast& other) {
  std::cout << absl::StreamFormat("| %s | %.1f | %.1f | %.2f | %.1f | %.1f | %.2f |\n", name,
                                  art.view, other.view, art.view / other.view, art.figures,
                                  other.figures, art.figures / other.figures);
}

// Prints one row per game, and the means over the games.
int CompareContrasts(const DrawingRequest& request, const SharedArt& other_art) {
  Progress progress(request.games.size());
  std::cout << "| game | view | other art | ratio | figures | other art | ratio |\n"
               "| --- | --- | --- | --- | --- | --- | --- |\n";
  Contrast mean;
  Contrast other_mean;
  int64_t weak_count = 0;
  const auto game_count = static_cast<double>(request.games.size());
  for (const GameSpec* game : request.games) {
    const Roles& roles = RolesOf(game->name);
    const Contrast contrast = MeasureContrast(roles, *request.art);
    const Contrast other = MeasureContrast(roles, other_art);
    progress.Finish(roles.game, absl::StrFormat("%.2f", contrast.view / other.view));
    PrintContrasts(roles.game, contrast, other);
    mean.view += contrast.view / game_count;
    mean.figures += contrast.figures / game_count;
    other_mean.view += other.view / game_count;
    other_mean.figures += other.figures / game_count;
    weak_count += contrast.view < absl::GetFlag(FLAGS_minimum) * other.view ? 1 : 0;
  }
  PrintContrasts("mean", mean, other_mean);
  return ReportWeak(weak_count, "games");
}

// "the art / the other art" of a mean and its spread over the levels.
std::string Pair(double mean, double spread, double other_mean, double other_spread) {
  return absl::StrFormat("%.0f ± %.0f / %.0f ± %.0f", mean, spread, other_mean, other_spread);
}

int CompareVarieties(const DrawingRequest& request, const SharedArt& other_art) {
  Progress progress(request.games.size());
  const int32_t level_count = absl::GetFlag(FLAGS_variety_levels);
  std::cout
      << "| game | backgrounds | looks | lightness | contrast | chroma | hue | colors | grain "
         "|\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const GameSpec* game : request.games) {
    const Roles& roles = RolesOf(game->name);
    const Variety art = MeasureVariety(roles, *request.art, level_count);
    const Variety other = MeasureVariety(roles, other_art, level_count);
    progress.Finish(roles.game, absl::StrFormat("%.1f", art.color_spread));
    std::cout << absl::StreamFormat(
        "| %s | %d | %d | %s | %s | %s | %.0f / %.0f | %.0f / %.0f | %.1f / %.1f |\n", roles.game,
        art.background_count, art.look_count,
        Pair(art.lightness, art.lightness_spread, other.lightness, other.lightness_spread),
        Pair(art.contrast, art.contrast_spread, other.contrast, other.contrast_spread),
        Pair(art.chroma, art.chroma_spread, other.chroma, other.chroma_spread), art.hue_spread,
        other.hue_spread, art.color_spread, other.color_spread, art.grain, other.grain);
  }
  return 0;
}

int Main(const std::vector<char*>& arguments) {
  if (const std::string error = CommandError(arguments); !error.empty()) {
    return Fail(error);
  }
  const auto request = MakeDrawingRequest(absl::GetFlag(FLAGS_games), absl::GetFlag(FLAGS_art_dir));
  if (!request.ok()) {
    return Fail(request.status().message());
  }
  const std::string other_folder = absl::GetFlag(FLAGS_contrast_to);
  if (other_folder.empty()) {
    return MeasureDistances(*request);
  }
  const auto other_art = SharedArt::LoadFolder(other_folder);
  if (!other_art.ok()) {
    return Fail(other_art.status().message());
  }
  return absl::GetFlag(FLAGS_variety_levels) > 0 ? CompareVarieties(*request, **other_art)
                                                 : CompareContrasts(*request, **other_art);
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Measures how well the parts of each game can be distinguished, or compares the contrast of "
      "two "
      "arts.\n"
      "usage: procgen-legibility [--games NAME,...] [--minimum X] [--crops FOLDER] "
      "[--art_dir FOLDER] [--contrast_to FOLDER [--variety_levels N]]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
