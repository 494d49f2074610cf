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

// The constants (return - min) / (max - min) that scores are normalised with. Source: Cobbe et al.
// 2020, appendix C.
struct ReturnRange {
  double min = 0;
  double max = 0;
};

// What an action from 9 on does in a game.
struct SpecialAction {
  int32_t action = 0;             // in [9, kActionCount)
  absl::string_view description;  // one sentence
};

// What is known of a game of the suite.
struct GameSpec {
  absl::string_view name;
  absl::string_view description;             // one sentence
  absl::Span<const DistributionMode> modes;  // without kExploration
  int32_t step_limit = 1000;                 // steps, then the episode is truncated
  int32_t step_limit_memory = 1000;          // in memory mode
  ReturnRange easy_returns;
  ReturnRange hard_returns;
  std::optional<int32_t> exploration_level;  // the level seed of exploration mode
  // In order of their numbers; one that is not listed does the same as action 4, nothing.
  absl::Span<const SpecialAction> special_actions;
  std::unique_ptr<Game> (*make)(const GameOptions&);

  bool HasMode(DistributionMode mode) const;
  int32_t StepLimit(DistributionMode mode) const {
    return mode == DistributionMode::kMemory ? step_limit_memory : step_limit;
  }
  // The seed of the game's generated art.
  uint32_t ArtSeed() const;
};

// The sixteen games, sorted by name.
absl::Span<const GameSpec> GameCatalog();

// A game by its name; null if the suite has none of that name.
const GameSpec* FindGame(absl::string_view name);

// "easy", "hard", "extreme", "memory", "exploration".
absl::string_view DistributionModeName(DistributionMode mode);
std::optional<DistributionMode> FindDistributionMode(absl::string_view name);

// What an action means, by its keys: "LEFT+DOWN" ... "E". REQUIRES: action in [0, kActionCount).
absl::string_view ActionName(int32_t action);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_CATALOG_H_
