#ifndef TESTS_SERVER_CLUSTER_CLUSTER_WATCH_H_
#define TESTS_SERVER_CLUSTER_CLUSTER_WATCH_H_

#include <functional>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "server/cluster/cluster.h"

namespace procgen {

// Waits for a condition on a node's view of its cluster.
class ClusterWatch {
 public:
  // `cluster` must outlive this object.
  explicit ClusterWatch(Cluster* cluster)
      : subscription_(cluster->Subscribe([this] {
          absl::MutexLock lock(&mutex_);
          changed_ = true;
        })) {}

  // Evaluates `is_expected()` at once and after each change. Returns false after `timeout`.
  bool Await(const std::function<bool()>& is_expected, absl::Duration timeout = absl::Seconds(20)) {
    const absl::Time end = absl::Now() + timeout;
    while (!is_expected()) {
      absl::MutexLock lock(&mutex_);
      if (!mutex_.AwaitWithDeadline(absl::Condition(&changed_), end)) {
        return false;
      }
      changed_ = false;
    }
    return true;
  }

 private:
  absl::Mutex mutex_;
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;
  Subscription subscription_;
};

}  // namespace procgen

#endif  // TESTS_SERVER_CLUSTER_CLUSTER_WATCH_H_
