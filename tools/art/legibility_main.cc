// procgen-legibility: measures whether the parts of a game can be distinguished at the size that an
// agent sees. See README.md.

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
#include "tools/art/images.h"
#include "tools/art/legibility.h"
#include "tools/art/requests.h"
#include "tools/progress.h"

ABSL_FLAG(std::vector<std::string>, games, {}, "games to measure, e.g. maze,heist; empty: all");
ABSL_FLAG(std::string, art_dir, "",
          "folder with art in the layout of Procgen 0.10.7; empty: the built-in art");
ABSL_FLAG(double, minimum, 0, "smallest distance that passes, at least 0");
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
  return "";
}

int Main(const std::vector<char*>& arguments) {
  if (const std::string error = CommandError(arguments); !error.empty()) {
    return Fail(error);
  }
  const auto request = MakeDrawingRequest(absl::GetFlag(FLAGS_games), absl::GetFlag(FLAGS_art_dir));
  if (!request.ok()) {
    return Fail(request.status().message());
  }
  Progress progress(request->games.size());
  int64_t weak_count = 0;
  for (const GameSpec* game : request->games) {
    const Roles& roles = RolesOf(game->name);
    const std::vector<PartDistance> likenesses =
        CompareParts(roles, *request->art,
                     [&](int64_t done, int64_t total) { progress.Show(roles.game, done, total); });
    progress.Finish(roles.game, absl::StrFormat("%.1f", likenesses.front().distance));
    PrintTable(roles, likenesses);
    if (absl::Status status = WriteCrops(roles, likenesses); !status.ok()) {
      return Fail(status.message());
    }
    weak_count += WeakCount(likenesses);
  }
  if (weak_count > 0) {
    std::cerr << weak_count << " pairs are below " << absl::GetFlag(FLAGS_minimum) << "\n";
  }
  return weak_count > 0 ? 1 : 0;
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  absl::SetProgramUsageMessage(
      "Measures how well the parts of each game can be distinguished. Prints a table per game.\n"
      "usage: procgen-legibility [--games NAME,...] [--minimum X] [--crops FOLDER] "
      "[--art_dir FOLDER]");
  return procgen::Main(absl::ParseCommandLine(argc, argv));
}
