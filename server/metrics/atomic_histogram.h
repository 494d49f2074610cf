#ifndef SERVER_METRICS_ATOMIC_HISTOGRAM_H_
#define SERVER_METRICS_ATOMIC_HISTOGRAM_H_

#include <atomic>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// What a histogram has counted.
struct HistogramCounts {
  std::vector<double> bounds;   // rising
  std::vector<int64_t> counts;  // [bounds + 1]: of values up to bounds[i] and above the one before
  double sum = 0;               // of all values
};

// Counts values between bounds. prometheus-cpp's own takes a mutex with each value, and streams
// would meet there. Threads: any method from any thread; none waits for another. What Counts
// returns may miss a value in one place and have it in another, if it is added meanwhile.
class AtomicHistogram {
 public:
  // `bounds`: rising; they must outlive this.
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
