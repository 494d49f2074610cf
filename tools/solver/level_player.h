#ifndef TOOLS_SOLVER_LEVEL_PLAYER_H_
#define TOOLS_SOLVER_LEVEL_PLAYER_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"

namespace procgen {

// One level of a game that can be played repeatedly from any of its states. The level is generated
// once, because generation is slow; states are saved from it and restored into it. Threads:
// compatible (one thread at a time).
class LevelPlayer {
 public:
  // Begins at the level's first step. REQUIRES: the game has the mode.
  LevelPlayer(const GameSpec& spec, DistributionMode mode, int32_t level_seed);

  // Plays one step. REQUIRES: !outcome().done.
  void Play(int32_t action) { game_->Play(action); }
  // Returns the current state. Ends the program if the state does not fit into a snapshot, which is
  // a bug.
  std::string Save();
  // Restores a state. REQUIRES: it is from Save of this player.
  void Restore(absl::string_view state);

  const StepOutcome& outcome() const { return game_->outcome(); }
  const World& world() const { return game_->world(); }
  int32_t step_number() const { return game_->step_number(); }
  // Step limit of an episode.
  int32_t step_limit() const { return step_limit_; }

 private:
  std::unique_ptr<Game> game_;
  int32_t step_limit_;
};

}  // namespace procgen

#endif  // TOOLS_SOLVER_LEVEL_PLAYER_H_
