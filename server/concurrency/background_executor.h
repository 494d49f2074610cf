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

// Threads for long operations other than steps: creating and freeing pools, saving states, drawing.
// They keep gRPC reactions and pool workers from blocking.
// Owners are served round robin: each has a queue, and a thread takes one work item from the queue
// served longest ago. So an owner waits at most for the items in progress and for one item of each
// other owner, however long their queues are.
// Threads: any method from any thread, including from a work item.
class BackgroundExecutor {
 public:
  using Work = absl::AnyInvocable<void()>;

  // `thread_count` >= 1.
  explicit BackgroundExecutor(int32_t thread_count);
  // Runs all submitted work, then ends the threads.
  ~BackgroundExecutor();
  BackgroundExecutor(const BackgroundExecutor&) = delete;
  BackgroundExecutor& operator=(const BackgroundExecutor&) = delete;

  // Submits work of `owner` and returns at once. Work of one owner starts in order of submission.
  // Work without an owner ("") has a queue of its own.
  void Run(absl::string_view owner, Work work);

 private:
  bool HasWorkOrStops() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stops_ || !turns_.empty();
  }
  // REQUIRES: a queue is not empty.
  Work TakeNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void WorkUntilStopped();

  absl::Mutex mutex_;
  std::deque<std::string> turns_ ABSL_GUARDED_BY(mutex_);  // keys of queues_, next owner first
  // none is empty
  absl::flat_hash_map<std::string, std::deque<Work>> queues_ ABSL_GUARDED_BY(mutex_);
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_BACKGROUND_EXECUTOR_H_
