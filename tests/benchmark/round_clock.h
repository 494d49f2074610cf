#ifndef TESTS_BENCHMARK_ROUND_CLOCK_H_
#define TESTS_BENCHMARK_ROUND_CLOCK_H_

#include "absl/time/time.h"
#include "tests/benchmark/time_now.h"
#include "tests/benchmark/yardstick.h"

namespace procgen {

// Takes the time of a repeated piece of work in rounds of 0.3 s and keeps the best round's mean:
// what else runs on the machine makes a round slower, never faster. Between the rounds it measures
// the Yardstick's unit, of which it keeps the best too, so that both are from the same minute.
// Threads: compatible (one thread at a time).
class RoundClock {
 public:
  explicit RoundClock(TimeKind kind) : kind_(kind) {}

  void Start() { start_ = TimeNow(kind_); }
  // Ends one piece of work; the next begins. Returns whether that completed a round: then call
  // MeasureUnit, out of the time that anything else measures, and Start.
  bool Lap();
  void MeasureUnit();

  // The time of one piece of work: of the best round, or of all work when no round was completed.
  // REQUIRES: Lap was called.
  absl::Duration Best() const;
  // The same as a number of units. REQUIRES: also MeasureUnit was called.
  double BestInUnits() const { return absl::FDivDuration(Best(), unit_); }

 private:
  TimeKind kind_;
  Yardstick yardstick_;
  absl::Duration start_;
  absl::Duration round_time_;  // of the round that runs
  int round_count_ = 0;        // pieces of work in it
  absl::Duration best_ = absl::InfiniteDuration();
  absl::Duration unit_ = absl::InfiniteDuration();
};

}  // namespace procgen

#endif  // TESTS_BENCHMARK_ROUND_CLOCK_H_
