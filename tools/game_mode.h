#ifndef TOOLS_GAME_MODE_H_
#define TOOLS_GAME_MODE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/games/game_catalog.h"
#include "envcore/games/game_options.h"

namespace procgen {

// A game in a mode that is played.
struct GameMode {
  const GameSpec* game = nullptr;
  DistributionMode mode = DistributionMode::kEasy;

  // "maze easy".
  std::string Name() const;
};

// Every game of `games` in every mode of `modes` (names), game by game, in their order. `known` are
// the games that can be asked for. Errors: INVALID_ARGUMENT a game that is not among them, a mode
// that there is none of or that a game lacks (the message says what is allowed).
absl::StatusOr<std::vector<GameMode>> MakeGameModes(const std::vector<std::string>& games,
                                                    const std::vector<std::string>& modes,
                                                    const std::vector<std::string>& known);

}  // namespace procgen

#endif  // TOOLS_GAME_MODE_H_
