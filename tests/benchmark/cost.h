#ifndef TESTS_BENCHMARK_COST_H_
#define TESTS_BENCHMARK_COST_H_

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/time/time.h"

namespace procgen {

// What one piece of repeated work takes.
struct Cost {
  absl::Duration wall = absl::InfiniteDuration();  // the time that goes by
  absl::Duration cpu =
      absl::InfiniteDuration();  // the time that all threads of this process compute

  // Does `work` over and over, for `round` or a little longer, and keeps the mean of one where it
  // is less than before, since what else runs on the machine makes a round slower, never faster.
  // Errors: those of `work`, the first of which ends the round.
  absl::Status MeasureRound(absl::Duration round, absl::FunctionRef<absl::Status()> work);
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_COST_H_
