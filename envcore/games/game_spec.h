#ifndef ENVCORE_GAMES_GAME_SPEC_H_
#define ENVCORE_GAMES_GAME_SPEC_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

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

// The name of a kind of entities or cells of a game, in states and tables that people and programs
// read. Rules do not use names.
struct KindName {
  int kind = 0;
  absl::string_view name;
  bool is_goal = false;  // to reach it, or all of it, completes the level
};

// Kinds with the same meaning in all games: agent, wall, explosion, trail, empty.
absl::Span<const KindName> CommonKindNames();

// What is known about a game without playing it. Each <game>.cc defines its own, as a constant.
struct GameSpec {
  absl::string_view name;
  absl::string_view description;             // one sentence
  absl::Span<const DistributionMode> modes;  // without kExploration
  int32_t step_limit = 1000;                 // steps until the episode is truncated
  int32_t step_limit_memory = 1000;          // in memory mode
  ReturnRange easy_returns;
  ReturnRange hard_returns;
  // Level seed of exploration mode; absent: no such mode.
  std::optional<int32_t> exploration_level = std::nullopt;
  // In order of action. An action that is not listed does nothing, like action 4.
  absl::Span<const SpecialAction> special_actions = {};
  absl::Span<const KindName> kinds;  // without those of CommonKindNames
  // Makes the game. REQUIRES: it has `distribution_mode`.
  std::unique_ptr<Game> (*make)(const GameOptions& options);

  bool HasMode(DistributionMode mode) const;
  int32_t StepLimit(DistributionMode mode) const {
    return mode == DistributionMode::kMemory ? step_limit_memory : step_limit;
  }
  // Seeds the game's generated art.
  uint32_t ArtSeed() const;

  // Of the game's kinds and the common ones. Returns the name of a kind; empty if it has none.
  absl::string_view NameOfKind(int kind) const;
  std::optional<int> FindKind(absl::string_view kind_name) const;
  // All names, for messages: "agent, wall, ...".
  std::string AllKindNames() const;
};

// Values of GameSpec.
inline constexpr DistributionMode kEasyHard[] = {DistributionMode::kEasy, DistributionMode::kHard};
inline constexpr DistributionMode kWithExtreme[] = {
    DistributionMode::kEasy, DistributionMode::kHard, DistributionMode::kExtreme};
inline constexpr DistributionMode kWithMemory[] = {DistributionMode::kEasy, DistributionMode::kHard,
                                                   DistributionMode::kMemory};
inline constexpr DistributionMode kAllModes[] = {DistributionMode::kEasy, DistributionMode::kHard,
                                                 DistributionMode::kExtreme,
                                                 DistributionMode::kMemory};

template <typename SomeGame>
std::unique_ptr<Game> MakeGame(const GameOptions& options) {
  return std::make_unique<SomeGame>(options);
}

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_SPEC_H_
