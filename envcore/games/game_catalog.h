#ifndef ENVCORE_GAMES_GAME_CATALOG_H_
#define ENVCORE_GAMES_GAME_CATALOG_H_

#include <cstdint>
#include <memory>
#include <optional>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/games/game.h"
#include "envcore/games/game_options.h"

namespace procgen {

// The constants of the normalized return, (return - min) / (max - min). Source: Cobbe et al. 2020,
// appendix C.
struct ReturnRange {
  double min = 0;
  double max = 0;
};

// What a special action does in a game.
struct SpecialAction {
  int32_t action = 0;             // in [9, kActionCount)
  absl::string_view description;  // one sentence
};

// The catalog entry of a game.
struct GameSpec {
  absl::string_view name;
  absl::string_view description;             // one sentence
  absl::Span<const DistributionMode> modes;  // without kExploration
  int32_t step_limit = 1000;                 // steps until the episode is truncated
  int32_t step_limit_memory = 1000;          // in memory mode
  ReturnRange easy_returns;
  ReturnRange hard_returns;
  std::optional<int32_t> exploration_level;  // level seed of exploration mode; absent: no such mode
  // In order of action. An action that is not listed does nothing, like action 4.
  absl::Span<const SpecialAction> special_actions;
  std::unique_ptr<Game> (*make)(const GameOptions&);

  bool HasMode(DistributionMode mode) const;
  int32_t StepLimit(DistributionMode mode) const {
    return mode == DistributionMode::kMemory ? step_limit_memory : step_limit;
  }
  // Seeds the game's generated art.
  uint32_t ArtSeed() const;
};

// The sixteen games, sorted by name.
absl::Span<const GameSpec> GameCatalog();

// Returns the game with this name, or null.
const GameSpec* FindGame(absl::string_view name);

// "easy", "hard", "extreme", "memory", "exploration".
absl::string_view DistributionModeName(DistributionMode mode);
std::optional<DistributionMode> FindDistributionMode(absl::string_view name);

// The name of an action by its keys, from "LEFT+DOWN" to "E". REQUIRES: action in [0,
// kActionCount).
absl::string_view ActionName(int32_t action);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_CATALOG_H_
