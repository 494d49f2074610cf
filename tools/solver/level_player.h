#ifndef TOOLS_SOLVER_LEVEL_PLAYER_H_
#define TOOLS_SOLVER_LEVEL_PLAYER_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"

namespace procgen {

// One level of a game that can be played over and over from any state it was in. The level is made
// once, which is what takes long: states go into it and come out of it, not into new ones.
// Threads: compatible (one thread at a time).
class LevelPlayer {
 public:
  // Stands at the level's first step. REQUIRES: the game has the mode.
  LevelPlayer(const GameSpec& spec, DistributionMode mode, int32_t level_seed);

  // Plays one step. REQUIRES: !outcome().done.
  void Play(int32_t action) { game_->Play(action); }
  // The state now. Dies where the game is in a state that no snapshot can hold, which is a bug.
  std::string Save();
  // Goes back to a state. REQUIRES: Save of this player gave it.
  void Restore(absl::string_view state);

  const StepOutcome& outcome() const { return game_->outcome(); }
  const World& world() const { return game_->world(); }
  int32_t step_number() const { return game_->step_number(); }
  // Steps that an episode of the level has at most.
  int32_t step_limit() const { return step_limit_; }

 private:
  std::unique_ptr<Game> game_;
  int32_t step_limit_;
};

}  // namespace procgen

#endif  // TOOLS_SOLVER_LEVEL_PLAYER_H_
