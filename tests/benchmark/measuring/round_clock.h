#ifndef TESTS_BENCHMARK_MEASURING_ROUND_CLOCK_H_
#define TESTS_BENCHMARK_MEASURING_ROUND_CLOCK_H_

#include "absl/time/time.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/benchmark/measuring/yardstick.h"

namespace procgen {

// Times a repeated workload in rounds of 0.3 s and keeps the mean of the best round: other load on
// the machine makes a round slower, never faster. Between rounds it measures the Yardstick's unit
// and keeps its best, so that both are measured in the same minute.
// Threads: compatible (one thread at a time).
class RoundClock {
 public:
  explicit RoundClock(TimeKind kind) : kind_(kind) {}

  void Start() { start_ = TimeNow(kind_); }
  // Ends one repetition and starts the next. Returns whether it completed a round; if so, call
  // MeasureUnit outside any other timing, then Start.
  bool Lap();
  void MeasureUnit();

  // Mean time of one repetition in the best round, or in all work if no round was completed.
  // REQUIRES: Lap was called.
  absl::Duration Best() const;
  // The same in units of the Yardstick. REQUIRES: Lap and MeasureUnit were called.
  double BestInUnits() const { return absl::FDivDuration(Best(), unit_); }

 private:
  TimeKind kind_;
  Yardstick yardstick_;
  absl::Duration start_;
  absl::Duration round_time_;  // of the current round
  int round_count_ = 0;        // repetitions in it
  absl::Duration best_ = absl::InfiniteDuration();
  absl::Duration unit_ = absl::InfiniteDuration();
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_ROUND_CLOCK_H_
