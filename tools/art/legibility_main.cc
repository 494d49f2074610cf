// procgen-legibility: measures whether the parts of a game can be distinguished at the size that an
// agent sees, and compares the contrast and the variety of two arts. See README.md.

#include <iostream>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "envcore/pool/shared_art.h"
#include "tools/art/contrast.h"
#include "tools/art/legibility.h"
#include "tools/art/requests.h"
#include "tools/art/variety.h"

ABSL_FLAG(std::vector<std::string>, games, {}, "games to measure, e.g. maze,heist; empty: all");
ABSL_FLAG(std::string, art_dir, "",
          "folder with art in the layout of Procgen 0.10.7; empty: the built-in art");
ABSL_FLAG(std::string, compare_to, "",
          "folder with art in the layout of Procgen 0.10.7: compare the contrast of the agent's "
          "views, and how much levels differ, with it, instead of measuring distances");
ABSL_FLAG(double, minimum, 0,
          "smallest distance that passes, or with --compare_to smallest ratio; at least 0");

namespace procgen {
namespace {

// A smaller difference of colors is not visible.
constexpr double kInvisibleDifference = 1;

int Fail(absl::string_view error) {
  std::cerr << "procgen-legibility: " << error << "\n";
  return 2;
}

std::string NameAndRole(const Part* part) {
  return part == nullptr ? "the backdrop | backdrop"
                         : absl::StrCat(part->name, " | ", RoleName(part->role));
}

std::string AppearanceName(const Appearance& appearance) {
  return appearance.image_kind == kDotImage
             ? "–"
             : absl::StrCat(appearance.image_kind, ".", appearance.theme);
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
              << NameAndRole(likeness.first) << " | " << NameAndRole(likeness.second) << " | "
              << AppearanceName(likeness.first_appearance) << " | "
              << AppearanceName(likeness.second_appearance) << " | " << likeness.backdrop << " |\n";
    least = false;
  }
}

// Returns an error in the command line; empty: none.
std::string CommandError(const std::vector<char*>& arguments) {
  if (arguments.size() > 1) {
    return absl::StrCat("unexpected argument '", arguments[1], "': only flags are allowed");
  }
  if (!(absl::GetFlag(FLAGS_minimum) >= 0)) {
    return absl::StrCat("--minimum ", absl::GetFlag(FLAGS_minimum), ": must be at least 0");
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
  int64_t weak_count = 0;
  for (const GameSpec* game : request.games) {
    const Roles& roles = RolesOf(game->name);
    const std::vector<PartDistance> likenesses = CompareParts(roles, *request.art);
    PrintTable(roles, likenesses);
    for (const PartDistance& likeness : likenesses) {
      weak_count += likeness.distance < absl::GetFlag(FLAGS_minimum) ? 1 : 0;
    }
  }
  return ReportWeak(weak_count, "pairs");
}

void PrintContrasts(absl::string_view name, const Contrast& art, const Contrast& other) {
  std::cout << absl::StreamFormat("| %s | %.1f | %.1f | %.2f | %.1f | %.1f | %.2f |\n", name,
                                  art.view, other.view, art.view / other.view, art.figures,
                                  other.figures, art.figures / other.figures);
}

// "the art / the other art" of a mean and its spread over the levels.
std::string Pair(double mean, double spread, double other_mean, double other_spread) {
  return absl::StrFormat("%.0f ± %.0f / %.0f ± %.0f", mean, spread, other_mean, other_spread);
}

std::string VarietyRow(absl::string_view game, const Variety& art, const Variety& other) {
  return absl::StrFormat(
      "| %s | %s | %s | %s | %.0f / %.0f | %.0f / %.0f | %.1f / %.1f |\n", game,
      Pair(art.lightness, art.lightness_spread, other.lightness, other.lightness_spread),
      Pair(art.contrast, art.contrast_spread, other.contrast, other.contrast_spread),
      Pair(art.chroma, art.chroma_spread, other.chroma, other.chroma_spread), art.hue_spread,
      other.hue_spread, art.color_spread, other.color_spread, art.grain, other.grain);
}

// Prints a table of contrasts, with the means over the games, and a table of varieties.
int CompareArts(const DrawingRequest& request, const SharedArt& other_art) {
  std::cout << "| game | view | other art | ratio | figures | other art | ratio |\n"
               "| --- | --- | --- | --- | --- | --- | --- |\n";
  Contrast mean;
  Contrast other_mean;
  std::string varieties;
  int64_t weak_count = 0;
  const double minimum = absl::GetFlag(FLAGS_minimum);
  const auto game_count = static_cast<double>(request.games.size());
  for (const GameSpec* game : request.games) {
    const Roles& roles = RolesOf(game->name);
    const Contrast contrast = MeasureContrast(roles, *request.art);
    const Contrast other = MeasureContrast(roles, other_art);
    PrintContrasts(roles.game, contrast, other);
    mean.view += contrast.view / game_count;
    mean.figures += contrast.figures / game_count;
    other_mean.view += other.view / game_count;
    other_mean.figures += other.figures / game_count;
    const Variety variety = MeasureVariety(roles, *request.art);
    const Variety other_variety = MeasureVariety(roles, other_art);
    absl::StrAppend(&varieties, VarietyRow(roles.game, variety, other_variety));
    const bool is_weak =
        contrast.figures < minimum * other.figures ||
        variety.color_spread + kInvisibleDifference < minimum * other_variety.color_spread;
    weak_count += is_weak ? 1 : 0;
  }
  PrintContrasts("mean", mean, other_mean);
  std::cout << "\n| game | lightness | contrast | chroma | hue | colors | grain |\n"
               "| --- | --- | --- | --- | --- | --- | --- |\n"
            << varieties;
  return ReportWeak(weak_count, "games");
}

int Main(const std::vector<char*>& arguments) {
  if (const std::string error = CommandError(arguments); !error.empty()) {
    return Fail(error);
  }
  const auto request = MakeDrawingRequest(absl::GetFlag(FLAGS_games), absl::GetFlag(FLAGS_art_dir));
  if (!request.ok()) {
    return Fail(request.status().message());
  }
  const std::string other_folder = absl::GetFlag(FLAGS_compare_to);
  if (other_folder.empty()) {
    return MeasureDistances(*request);
  }
  const auto other_art = SharedArt::LoadFolder(other_folder);
  if (!other_art.ok()) {
    return Fail(other_art.status().message());
  }
  return CompareArts(*request, **other_art);
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Measures how well the parts of each game can be distinguished, or compares two arts.\n"
      "usage: procgen-legibility [--games NAME,...] [--minimum X] [--art_dir FOLDER] "
      "[--compare_to FOLDER]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
