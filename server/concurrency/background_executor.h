#ifndef SERVER_CONCURRENCY_BACKGROUND_EXECUTOR_H_
#define SERVER_CONCURRENCY_BACKGROUND_EXECUTOR_H_

#include <cstdint>
#include <deque>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/functional/any_invocable.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// A few threads for work that takes long and is no step: making and freeing pools, saving states,
// drawing. So reactions of the transport do not block, and workers keep stepping.
// Owners are served in turn (round robin): each has a queue, and a thread takes one piece of work
// from the queue whose turn was longest ago. However long the queue of one owner is, another waits
// for the work that has begun and for one piece of each owner in line before it.
// Threads: any method from any thread, also from the work itself.
class BackgroundExecutor {
 public:
  using Work = absl::AnyInvocable<void()>;

  // `thread_count` >= 1. Throws std::system_error where a thread cannot be started; none is left.
  explicit BackgroundExecutor(int32_t thread_count);
  // Carries out all work that was handed over, then ends the threads.
  ~BackgroundExecutor();
  BackgroundExecutor(const BackgroundExecutor&) = delete;
  BackgroundExecutor& operator=(const BackgroundExecutor&) = delete;

  // Hands over work of `owner` and returns at once. Work of one owner begins in the order of
  // handing over. Work of nobody ("") has a queue as that of an owner has.
  void Run(absl::string_view owner, Work work);

 private:
  bool HasWorkOrStops() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stops_ || !turns_.empty();
  }
  // REQUIRES: some work waits.
  Work TakeNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void WorkUntilStopped();
  void Stop();

  absl::Mutex mutex_;
  std::deque<std::string> turns_ ABSL_GUARDED_BY(mutex_);  // keys of queues_, the next owner first
  absl::flat_hash_map<std::string, std::deque<Work>> queues_ ABSL_GUARDED_BY(mutex_);  // none empty
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_BACKGROUND_EXECUTOR_H_
