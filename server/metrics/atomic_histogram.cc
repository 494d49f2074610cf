#include "server/metrics/atomic_histogram.h"

#include <algorithm>
#include <cstddef>

namespace procgen {

AtomicHistogram::AtomicHistogram(absl::Span<const double> bounds)
    : bounds_(bounds), counts_(bounds.size() + 1) {}

void AtomicHistogram::Add(double value) {
  const auto* const bound = std::lower_bound(bounds_.begin(), bounds_.end(), value);
  counts_[static_cast<size_t>(bound - bounds_.begin())].fetch_add(1, std::memory_order_relaxed);
  sum_.fetch_add(value, std::memory_order_relaxed);
}

HistogramCounts AtomicHistogram::Counts() const {
  HistogramCounts counted;
  counted.bounds.assign(bounds_.begin(), bounds_.end());
  counted.counts.assign(counts_.begin(), counts_.end());
  counted.sum = sum_.load(std::memory_order_relaxed);
  return counted;
}

}  // namespace procgen
