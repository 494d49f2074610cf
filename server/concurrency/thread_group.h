#ifndef SERVER_CONCURRENCY_THREAD_GROUP_H_
#define SERVER_CONCURRENCY_THREAD_GROUP_H_

#include <atomic>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// A bounded set of threads, all of which end before it is destroyed.
// Threads: any method from any thread that is not one of them.
class ThreadGroup {
 public:
  // `full_error` is the message of Start's error while `count_max` threads run.
  ThreadGroup(size_t count_max, std::string full_error)
      : count_max_(count_max), full_error_(std::move(full_error)) {}
  // Waits until all have ended.
  ~ThreadGroup();
  ThreadGroup(const ThreadGroup&) = delete;
  ThreadGroup& operator=(const ThreadGroup&) = delete;

  // Runs `work` on a new thread. Errors: RESOURCE_EXHAUSTED the group is full, or the process is at
  // its thread limit.
  absl::Status Start(std::function<void()> work);

 private:
  struct Entry {
    std::thread thread;
    std::shared_ptr<std::atomic<bool>> has_ended;
  };

  // Joins threads that have ended.
  void Reap() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t count_max_;
  const std::string full_error_;
  absl::Mutex mutex_;
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_THREAD_GROUP_H_
