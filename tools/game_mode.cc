#include "tools/game_mode.h"

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace procgen {
namespace {

std::string ModeNames(const GameSpec& game) {
  return absl::StrJoin(game.modes, ", ", [](std::string* out, DistributionMode mode) {
    absl::StrAppend(out, DistributionModeName(mode));
  });
}

}  // namespace

std::string GameMode::Name() const {
  return absl::StrCat(game->name, " ", DistributionModeName(mode));
}

absl::StatusOr<std::vector<GameMode>> MakeGameModes(const std::vector<std::string>& games,
                                                    const std::vector<std::string>& modes,
                                                    const std::vector<std::string>& known) {
  std::vector<GameMode> game_modes;
  for (const std::string& name : games) {
    const GameSpec* game = FindGame(name);
    if (game == nullptr || std::find(known.begin(), known.end(), name) == known.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("game '", name, "' is not one of ", absl::StrJoin(known, ", ")));
    }
    for (const std::string& mode_name : modes) {
      const std::optional<DistributionMode> mode = FindDistributionMode(mode_name);
      if (!mode.has_value() || !game->HasMode(*mode)) {
        return absl::InvalidArgumentError(absl::StrCat("mode '", mode_name, "' is not one of ",
                                                       name, "'s modes: ", ModeNames(*game)));
      }
      game_modes.push_back({.game = game, .mode = *mode});
    }
  }
  return game_modes;
}

}  // namespace procgen
