#ifndef SERVER_POOL_REQUEST_PAUSE_H_
#define SERVER_POOL_REQUEST_PAUSE_H_

#include <atomic>
#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// Whether the requests of a pool's stream wait, and how many may pass nevertheless. Other calls are
// not affected. Threads: any method from any thread, but one Pass at a time.
class RequestPause {
 public:
  using Begin = absl::AnyInvocable<void()>;

  // Pauses are counted: requests wait until each has ended.
  void Pause();
  void EndPause();
  // While paused, lets one more request pass: the waiting one or else the next.
  void PassOne();
  // The stream ends: its requests do not wait any more.
  void PassStream();

  bool paused() const { return pause_count_ > 0; }
  // Calls `begin` once, on this thread or on that of the method that lets the request pass.
  void Pass(Begin begin);

 private:
  bool MayPass() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return pause_count_ == 0 || passes_left_ > 0 || passes_stream_;
  }
  // Calls the waiting request's `begin` if it may pass.
  void Wake();

  absl::Mutex mutex_;
  std::atomic<int32_t> pause_count_ = 0;  // written with mutex_ held
  int32_t passes_left_ ABSL_GUARDED_BY(mutex_) = 0;
  bool passes_stream_ ABSL_GUARDED_BY(mutex_) = false;
  Begin waiting_ ABSL_GUARDED_BY(mutex_);  // null: no request waits
};

}  // namespace procgen

#endif  // SERVER_POOL_REQUEST_PAUSE_H_
