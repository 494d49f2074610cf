#ifndef SERVER_SESSION_POOL_TURN_QUEUE_H_
#define SERVER_SESSION_POOL_TURN_QUEUE_H_

#include <cstddef>
#include <deque>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// How many callers may wait for their turn at one pool.
inline constexpr size_t kTurnsWaitingMax = 64;

// Gives turns at a pool: one at a time, in the order in which they were asked for. A turn begins in
// a callback; nothing here blocks.
// Threads: any method from any thread.
class TurnQueue {
 public:
  using Begin = absl::AnyInvocable<void(absl::Status)>;

  // `pool_name`: for errors.
  explicit TurnQueue(std::string pool_name) : pool_name_(std::move(pool_name)) {}

  // Calls `begin` with OK when it is the caller's turn (on this thread, or one that ends a turn),
  // who then must call End once; or with an error, and there is no turn: after Close, its reason;
  // RESOURCE_EXHAUSTED kTurnsWaitingMax others wait.
  void Take(Begin begin);
  void End();
  // Lets no turn begin any more. Returns those that wait, to be called with `reason`.
  std::deque<Begin> Close(const absl::Status& reason);

 private:
  const std::string pool_name_;
  absl::Mutex mutex_;
  bool is_taken_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<Begin> waiting_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  // OK while open
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_TURN_QUEUE_H_
