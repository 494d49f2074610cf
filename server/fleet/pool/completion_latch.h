#ifndef SERVER_FLEET_POOL_COMPLETION_LATCH_H_
#define SERVER_FLEET_POOL_COMPLETION_LATCH_H_

#include <cstddef>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "server/session/backend/pool_backend.h"

namespace procgen {

// Calls `done` with the first error, or OK, when `count` operations have ended.
// Threads: any method from any thread.
class CompletionLatch {
 public:
  CompletionLatch(size_t count, PoolBackend::Done done) : left_(count), done_(std::move(done)) {}

  void CountDown(const absl::Status& status) {
    bool is_last = false;
    absl::Status result;
    {
      absl::MutexLock lock(&mutex_);
      status_.Update(status);
      is_last = --left_ == 0;
      result = status_;
    }
    if (is_last) {
      done_(std::move(result));
    }
  }

 private:
  absl::Mutex mutex_;
  size_t left_ ABSL_GUARDED_BY(mutex_);
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  PoolBackend::Done done_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_COMPLETION_LATCH_H_
