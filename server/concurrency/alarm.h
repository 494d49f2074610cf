#ifndef SERVER_CONCURRENCY_ALARM_H_
#define SERVER_CONCURRENCY_ALARM_H_

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

// One thread that rings when it is time: that the next lease runs out, that somebody is to be shown
// something.
// Threads: any method from any thread.
class Alarm {
 public:
  // Calls, on the alarm's thread, that are told the time and return when they want the next one;
  // InfiniteFuture: only once somebody asks for it.
  using Ring = absl::AnyInvocable<absl::Time(absl::Time now)>;

  Alarm(Clock clock, Ring ring);
  // Waits for a ring under way.
  ~Alarm();
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  absl::Time Now() const { return clock_(); }
  // Rings at `time`, or before.
  void RingBy(absl::Time time);

 private:
  void RingUntilStopped();

  const Clock clock_;
  Ring ring_;  // of the thread
  // Not absl's, which wait by the time of day.
  std::mutex mutex_;
  std::condition_variable changed_;
  absl::Time next_ring_ = absl::InfiniteFuture();  // guarded by mutex_
  bool stops_ = false;                             // guarded by mutex_
  std::thread thread_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_ALARM_H_
