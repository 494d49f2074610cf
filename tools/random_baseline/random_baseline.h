#ifndef TOOLS_RANDOM_BASELINE_RANDOM_BASELINE_H_
#define TOOLS_RANDOM_BASELINE_RANDOM_BASELINE_H_

#include <cstdint>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "tools/game_mode.h"

namespace procgen {

struct RandomPlay {
  int32_t env_count = 50;                 // environments of the pool
  int32_t episodes_per_environment = 40;  // the first episodes of each environment
  int32_t worker_count = 1;               // threads, including the calling one
  int64_t seed = 0;                       // of levels and actions
};

// Statistics of the returns of random play.
struct ReturnStatistics {
  int64_t episode_count = 0;
  double return_mean = 0;
  double return_error = 0;  // standard error of the mean
  double length_mean = 0;   // steps
};

// Plays a game with uniform random actions on unlimited levels. Counts the first episodes of each
// environment: the first episodes of all environments together would over-represent short ones.
// Results depend on all arguments but the number of workers. `show` is called repeatedly with the
// number of counted episodes. Errors: as Pool::Create. REQUIRES: counts above 0.
absl::StatusOr<ReturnStatistics> PlayRandomly(const GameMode& game_mode, const RandomPlay& play,
                                              absl::FunctionRef<void(int64_t)> show);

}  // namespace procgen

#endif  // TOOLS_RANDOM_BASELINE_RANDOM_BASELINE_H_
