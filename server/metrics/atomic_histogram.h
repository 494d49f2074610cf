#ifndef SERVER_METRICS_ATOMIC_HISTOGRAM_H_
#define SERVER_METRICS_ATOMIC_HISTOGRAM_H_

#include <atomic>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// The contents of a histogram.
struct HistogramCounts {
  std::vector<double> bounds;   // ascending upper bounds of the buckets
  std::vector<int64_t> counts;  // values per bucket [bounds + 1]; the last has no upper bound
  double sum = 0;               // of all values
};

// A lock-free histogram. prometheus-cpp's takes a mutex for each value, for which streams would
// contend.
// Threads: any method from any thread; none blocks. A value that is added during Counts may be in
// `counts` and not in `sum`, or the reverse.
class AtomicHistogram {
 public:
  // `bounds`: ascending; must outlive this.
  explicit AtomicHistogram(absl::Span<const double> bounds);
  AtomicHistogram(const AtomicHistogram&) = delete;
  AtomicHistogram& operator=(const AtomicHistogram&) = delete;

  void Add(double value);
  HistogramCounts Counts() const;

 private:
  const absl::Span<const double> bounds_;
  std::vector<std::atomic<int64_t>> counts_;  // [bounds + 1]
  std::atomic<double> sum_ = 0;
};

}  // namespace procgen

#endif  // SERVER_METRICS_ATOMIC_HISTOGRAM_H_
