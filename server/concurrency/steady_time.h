#ifndef SERVER_CONCURRENCY_STEADY_TIME_H_
#define SERVER_CONCURRENCY_STEADY_TIME_H_

#include <condition_variable>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace procgen {

// The system time at program start plus the elapsed steady time. Setting the system clock moves no
// deadline.
absl::Time SteadyNow();

// A condition variable for an absl::Mutex, with deadlines in SteadyNow time. Abseil's own timed
// waits follow the system clock.
// Threads: any method from any thread.
class SteadyCondVar {
 public:
  // Releases `mutex` until `is_due()` or `deadline`. `is_due` is called with `mutex` held, after
  // each NotifyAll. Returns its last result.
  template <typename Predicate>
  bool AwaitUntil(absl::Mutex* mutex, absl::Time deadline, Predicate is_due)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    while (!is_due()) {
      if (!WaitUntil(mutex, deadline)) {
        return is_due();
      }
    }
    return true;
  }

  // Call after each change that may make an `is_due()` true.
  void NotifyAll() { changed_.notify_all(); }

 private:
  // Returns false if the deadline has passed.
  bool WaitUntil(absl::Mutex* mutex, absl::Time deadline);

  std::condition_variable_any changed_;
};

// An absl::Notification with a timeout on the steady clock. Threads: any method from any thread.
class SteadyNotification {
 public:
  void Notify();
  bool HasBeenNotified() const;
  // Returns whether it was notified; false after `timeout`.
  bool WaitWithTimeout(absl::Duration timeout) const;

 private:
  mutable absl::Mutex mutex_;
  mutable SteadyCondVar changed_;
  bool notified_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_STEADY_TIME_H_
