#ifndef SERVER_SESSION_POOL_REQUEST_TIMES_H_
#define SERVER_SESSION_POOL_REQUEST_TIMES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// How long a pool's requests took: all of them together, and the last ones each.
// Threads: Add by one at a time, Read from any, at any time.
class RequestTimes {
 public:
  // A summary is of so many.
  static constexpr size_t kRecentCount = 512;

  struct Summary {
    int64_t count = 0;   // of all requests
    absl::Duration sum;  // likewise
    absl::Duration p50;  // of the last kRecentCount; 0 without any
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

#endif  // SERVER_SESSION_POOL_REQUEST_TIMES_H_
