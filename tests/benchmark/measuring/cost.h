#ifndef TESTS_BENCHMARK_MEASURING_COST_H_
#define TESTS_BENCHMARK_MEASURING_COST_H_

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/time/time.h"

namespace procgen {

// Cost of one repetition of a workload.
struct Cost {
  absl::Duration wall = absl::InfiniteDuration();  // wall time
  absl::Duration cpu = absl::InfiniteDuration();   // CPU time of all threads of this process

  // Repeats `work` for at least `round` and lowers `wall` and `cpu` to the means of this round if
  // they are smaller: other load on the machine makes a round slower, never faster. Errors: the
  // first error of `work`, which ends the round.
  absl::Status MeasureRound(absl::Duration round, absl::FunctionRef<absl::Status()> work);
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_COST_H_
