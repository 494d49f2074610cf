#ifndef SERVER_CONCURRENCY_DEADLINE_TIMER_H_
#define SERVER_CONCURRENCY_DEADLINE_TIMER_H_

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "absl/functional/any_invocable.h"
#include "absl/time/time.h"
#include "server/concurrency/steady_time.h"

namespace procgen {

// Returns the current time. Called from any thread.
using Clock = std::function<absl::Time()>;

// One thread that calls back at a deadline, such as that of the next frame set.
// Threads: any method from any thread.
class DeadlineTimer {
 public:
  // Called on the timer's thread with the current time. Returns the next deadline; InfiniteFuture:
  // none until ArmBy.
  using Callback = absl::AnyInvocable<absl::Time(absl::Time now)>;

  DeadlineTimer(Clock clock, Callback callback);
  // Waits for a running callback.
  ~DeadlineTimer();
  DeadlineTimer(const DeadlineTimer&) = delete;
  DeadlineTimer& operator=(const DeadlineTimer&) = delete;

  absl::Time Now() const { return clock_(); }
  // Makes the callback run at `time` or earlier.
  void ArmBy(absl::Time time);

 private:
  void RunUntilStopped();

  const Clock clock_;
  Callback callback_;  // used by the thread only
  // Not absl's, which wait on the system clock.
  std::mutex mutex_;
  std::condition_variable changed_;
  absl::Time deadline_ = absl::InfiniteFuture();  // guarded by mutex_
  bool stops_ = false;                            // guarded by mutex_
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_DEADLINE_TIMER_H_
