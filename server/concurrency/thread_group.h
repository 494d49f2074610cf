#ifndef SERVER_CONCURRENCY_THREAD_GROUP_H_
#define SERVER_CONCURRENCY_THREAD_GROUP_H_

#include <atomic>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// Threads that come and go, at most so many at a time, and of which none outlives this. Threads:
// any method from any thread that is none of them.
class ThreadGroup {
 public:
  explicit ThreadGroup(size_t count_max) : count_max_(count_max) {}
  // Waits until all have ended.
  ~ThreadGroup();
  ThreadGroup(const ThreadGroup&) = delete;
  ThreadGroup& operator=(const ThreadGroup&) = delete;

  // Runs `work` on a thread of its own. Errors: RESOURCE_EXHAUSTED there are as many as may be, or
  // the process may have no more threads.
  absl::Status Start(std::function<void()> work);
  // Whether one more would start.
  bool HasRoom() const;

 private:
  struct Entry {
    std::thread thread;
    std::shared_ptr<std::atomic<bool>> has_ended;
  };

  // Lets go of those that have ended.
  void Reap() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t count_max_;
  mutable absl::Mutex mutex_;
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_THREAD_GROUP_H_
