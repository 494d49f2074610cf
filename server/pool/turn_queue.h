#ifndef SERVER_POOL_TURN_QUEUE_H_
#define SERVER_POOL_TURN_QUEUE_H_

#include <cstddef>
#include <deque>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// Maximum number of callers that wait for a turn at one pool.
inline constexpr size_t kTurnsWaitingMax = 64;

// A first-come-first-served queue of turns at a pool. A turn begins in a callback; nothing blocks.
// Threads: any method from any thread.
class TurnQueue {
 public:
  using Begin = absl::AnyInvocable<void(absl::Status)>;

  // `pool_name`: for errors.
  explicit TurnQueue(std::string pool_name) : pool_name_(std::move(pool_name)) {}

  // Calls `begin` with OK when the caller's turn begins, on this thread or on one that ends a turn;
  // the caller must then call End once. Calls it with an error instead: the reason of Close;
  // RESOURCE_EXHAUSTED kTurnsWaitingMax others wait.
  void Take(Begin begin);
  void End();
  // Rejects new turns. Returns the waiting callbacks, which the caller must call with `reason`.
  std::deque<Begin> Close(const absl::Status& reason);

 private:
  const std::string pool_name_;
  absl::Mutex mutex_;
  bool is_taken_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<Begin> waiting_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  // OK while open
};

}  // namespace procgen

#endif  // SERVER_POOL_TURN_QUEUE_H_
