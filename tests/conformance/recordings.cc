#include "tests/conformance/recordings.h"

#include <algorithm>
#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "envcore/games/game_catalog.h"

namespace procgen {
namespace {

std::string BesideTheCheckout(const std::string& name) {
  const std::string folder = absl::StrCat(PROCGEN_SOURCE_DIR, "/../shared/", name);
  return std::filesystem::is_directory(folder) ? folder : "";
}

}  // namespace

std::string ReferenceFolder() { return BesideTheCheckout("reference"); }

std::string UpstreamArtFolder() { return BesideTheCheckout("released-art"); }

std::vector<std::string> TracesIn(const std::string& folder) { return TracesOf("", folder); }

std::vector<std::string> TracesOf(const std::string& game, const std::string& folder) {
  const std::string prefix = game.empty() ? "" : absl::StrCat(game, ".");
  std::vector<std::string> paths;
  if (std::filesystem::is_directory(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".trace" &&
          absl::StartsWith(entry.path().filename().string(), prefix)) {
        paths.push_back(entry.path().string());
      }
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<std::string> GamesOfTheCatalog() {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    names.emplace_back(game.name);
  }
  return names;
}

}  // namespace procgen
