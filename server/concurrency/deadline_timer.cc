#include "server/concurrency/deadline_timer.h"

#include <algorithm>
#include <utility>

namespace procgen {

DeadlineTimer::DeadlineTimer(Clock clock, Callback callback)
    : clock_(std::move(clock)),
      callback_(std::move(callback)),
      thread_([this] { RunUntilStopped(); }) {}

DeadlineTimer::~DeadlineTimer() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
    changed_.notify_one();
  }
  thread_.join();
}

void DeadlineTimer::ArmBy(absl::Time time) {
  const std::lock_guard lock(mutex_);
  if (time < deadline_) {
    deadline_ = time;
    changed_.notify_one();
  }
}

void DeadlineTimer::RunUntilStopped() {
  std::unique_lock lock(mutex_);
  while (!stops_) {
    const absl::Time now = clock_();
    if (deadline_ == absl::InfiniteFuture()) {
      changed_.wait(lock);
      continue;
    }
    if (deadline_ > now) {
      changed_.wait_for(lock, absl::ToChronoNanoseconds(deadline_ - now));
      continue;
    }
    deadline_ = absl::InfiniteFuture();
    lock.unlock();
    const absl::Time next = callback_(now);
    lock.lock();
    deadline_ = std::min(deadline_, next);
  }
}

}  // namespace procgen
