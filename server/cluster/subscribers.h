#ifndef SERVER_CLUSTER_SUBSCRIBERS_H_
#define SERVER_CLUSTER_SUBSCRIBERS_H_

#include <cstdint>
#include <map>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/synchronization/mutex.h"
#include "server/cluster/subscription.h"

namespace procgen {

// The subscribers to changes. Threads: any method from any thread.
class Subscribers {
 public:
  // The returned subscription must end before this does.
  Subscription Add(absl::AnyInvocable<void()> changed) {
    absl::MutexLock lock(&mutex_);
    const int64_t number = ++last_;
    subscribers_.emplace(number, std::move(changed));
    return Subscription([this, number] { Remove(number); });
  }

  // Notifies all subscribers. Subscribe and unsubscribe block meanwhile, so callbacks must not wait
  // for them.
  void Notify() {
    absl::MutexLock lock(&mutex_);
    for (auto& [number, changed] : subscribers_) {
      changed();
    }
  }

 private:
  void Remove(int64_t number) {
    absl::MutexLock lock(&mutex_);
    subscribers_.erase(number);
  }

  absl::Mutex mutex_;
  std::map<int64_t, absl::AnyInvocable<void()>> subscribers_ ABSL_GUARDED_BY(mutex_);
  int64_t last_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_SUBSCRIBERS_H_
