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

// Tells the time. Called from any thread.
using Clock = std::function<absl::Time()>;

// One thread that calls back when a deadline has come: that the next lease runs out, that somebody
// is to be shown something.
// Threads: any method from any thread.
class DeadlineTimer {
 public:
  // Calls, on the timer's thread, that are told the time and return when they want the next one;
  // InfiniteFuture: only once somebody asks for it.
  using Callback = absl::AnyInvocable<absl::Time(absl::Time now)>;

  DeadlineTimer(Clock clock, Callback callback);
  // Waits for a callback under way.
  ~DeadlineTimer();
  DeadlineTimer(const DeadlineTimer&) = delete;
  DeadlineTimer& operator=(const DeadlineTimer&) = delete;

  absl::Time Now() const { return clock_(); }
  // Calls back at `time`, or before.
  void ArmBy(absl::Time time);

 private:
  void RunUntilStopped();

  const Clock clock_;
  Callback callback_;  // of the thread
  // Not absl's, which wait by the time of day.
  std::mutex mutex_;
  std::condition_variable changed_;
  absl::Time deadline_ = absl::InfiniteFuture();  // guarded by mutex_
  bool stops_ = false;                            // guarded by mutex_
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_DEADLINE_TIMER_H_
