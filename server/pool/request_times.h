#ifndef SERVER_POOL_REQUEST_TIMES_H_
#define SERVER_POOL_REQUEST_TIMES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// Latencies of a pool's requests: the total, and percentiles of the most recent ones.
// Threads: Add one call at a time; Read from any thread at any time.
class RequestTimes {
 public:
  // Number of requests that the percentiles cover.
  static constexpr size_t kRecentCount = 512;

  struct Summary {
    int64_t count = 0;   // of all requests
    absl::Duration sum;  // likewise
    absl::Duration p50;  // of the last kRecentCount; 0 if none
    absl::Duration p99;  // likewise
  };

  void Add(absl::Duration duration);
  Summary Read() const;

 private:
  std::atomic<int64_t> count_ = 0;
  std::atomic<int64_t> sum_ns_ = 0;
  std::array<std::atomic<int64_t>, kRecentCount> recent_ns_ = {};  // number n at n % kRecentCount
};

}  // namespace procgen

#endif  // SERVER_POOL_REQUEST_TIMES_H_
