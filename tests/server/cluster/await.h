#ifndef TESTS_SERVER_CLUSTER_AWAIT_H_
#define TESTS_SERVER_CLUSTER_AWAIT_H_

#include <functional>

#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace procgen {

// Waits until `is_expected()`, e.g. of a node's view of its cluster. Returns false after `timeout`.
inline bool Await(const std::function<bool()>& is_expected,
                  absl::Duration timeout = absl::Seconds(20)) {
  const absl::Time end = absl::Now() + timeout;
  while (!is_expected()) {
    if (absl::Now() > end) {
      return false;
    }
    absl::SleepFor(absl::Milliseconds(5));
  }
  return true;
}

}  // namespace procgen

#endif  // TESTS_SERVER_CLUSTER_AWAIT_H_
