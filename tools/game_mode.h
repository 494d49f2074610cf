#ifndef TOOLS_GAME_MODE_H_
#define TOOLS_GAME_MODE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/games/game_catalog.h"
#include "envcore/games/game_options.h"

namespace procgen {

// A game and a distribution mode.
struct GameMode {
  const GameSpec* game = nullptr;
  DistributionMode mode = DistributionMode::kEasy;

  // "maze easy".
  std::string Name() const;
};

// Returns every combination of `games` and `modes` (names), game by game, in the given order.
// `known`: the games that are allowed. Errors: INVALID_ARGUMENT: a game is not in `known`, a mode
// does not exist, or the game does not have it (the message says what is allowed).
absl::StatusOr<std::vector<GameMode>> MakeGameModes(const std::vector<std::string>& games,
                                                    const std::vector<std::string>& modes,
                                                    const std::vector<std::string>& known);

}  // namespace procgen

#endif  // TOOLS_GAME_MODE_H_
