#include "server/pool/request_times.h"

#include <algorithm>
#include <vector>

namespace procgen {
namespace {

// The smallest of `values` that is >= `percent` in 100 of them. REQUIRES: not empty.
int64_t PercentileOf(size_t percent, std::vector<int64_t>* values) {
  const size_t rank = (values->size() * percent + 99) / 100;
  const auto at = values->begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(values->begin(), at, values->end());
  return *at;
}

}  // namespace

void RequestTimes::Add(absl::Duration duration) {
  const int64_t nanoseconds = absl::ToInt64Nanoseconds(duration);
  const int64_t number = count_.load(std::memory_order_relaxed);
  recent_ns_[static_cast<size_t>(number) % kRecentCount].store(nanoseconds,
                                                               std::memory_order_relaxed);
  sum_ns_.store(sum_ns_.load(std::memory_order_relaxed) + nanoseconds, std::memory_order_relaxed);
  count_.store(number + 1, std::memory_order_release);
}

RequestTimes::Summary RequestTimes::Read() const {
  Summary summary;
  summary.count = count_.load(std::memory_order_acquire);
  summary.sum = absl::Nanoseconds(sum_ns_.load(std::memory_order_relaxed));
  std::vector<int64_t> recent(std::min(static_cast<size_t>(summary.count), kRecentCount));
  for (size_t i = 0; i < recent.size(); ++i) {
    recent[i] = recent_ns_[i].load(std::memory_order_relaxed);
  }
  if (!recent.empty()) {
    summary.p50 = absl::Nanoseconds(PercentileOf(50, &recent));
    summary.p99 = absl::Nanoseconds(PercentileOf(99, &recent));
  }
  return summary;
}

}  // namespace procgen
