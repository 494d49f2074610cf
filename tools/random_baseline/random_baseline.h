#ifndef TOOLS_RANDOM_BASELINE_RANDOM_BASELINE_H_
#define TOOLS_RANDOM_BASELINE_RANDOM_BASELINE_H_

#include <cstdint>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "tools/game_mode.h"

namespace procgen {

struct RandomPlay {
  int32_t env_count = 50;                 // environments side by side
  int32_t episodes_per_environment = 40;  // of each the first ones count
  int32_t worker_count = 1;               // threads, the calling one among them
  int64_t seed = 0;                       // of levels and actions
};

// Returns of episodes of random play.
struct ReturnStatistics {
  int64_t episode_count = 0;
  double return_mean = 0;
  double return_error = 0;  // standard error of the mean
  double length_mean = 0;   // steps
};

// Plays a game in a mode on all levels, each action drawn evenly from all of them, and counts the
// first episodes of each environment: the first to end among all environments would be too often
// short ones. Equal arguments but the workers' number give equal results. `show` is called now and
// then with the number of episodes that count so far. Errors: as Pool::Create. REQUIRES: counts
// above 0.
absl::StatusOr<ReturnStatistics> PlayRandomly(const GameMode& game_mode, const RandomPlay& play,
                                              absl::FunctionRef<void(int64_t)> show);

}  // namespace procgen

#endif  // TOOLS_RANDOM_BASELINE_RANDOM_BASELINE_H_
