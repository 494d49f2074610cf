#include "tests/benchmark/measuring/round_clock.h"

#include <algorithm>

namespace procgen {
namespace {

constexpr absl::Duration kRound = absl::Milliseconds(300);

}  // namespace

bool RoundClock::Lap() {
  const absl::Duration now = TimeNow(kind_);
  round_time_ += now - start_;
  start_ = now;
  ++round_count_;
  if (round_time_ < kRound) {
    return false;
  }
  best_ = std::min(best_, round_time_ / round_count_);
  round_time_ = absl::ZeroDuration();
  round_count_ = 0;
  return true;
}

void RoundClock::MeasureUnit() { unit_ = std::min(unit_, yardstick_.MeasureUnit()); }

absl::Duration RoundClock::Best() const {
  return best_ == absl::InfiniteDuration() ? round_time_ / round_count_ : best_;
}

}  // namespace procgen
