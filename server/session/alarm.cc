#include "server/session/alarm.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/time/clock.h"

namespace procgen {

absl::Time SteadyNow() {
  using Steady = std::chrono::steady_clock;
  static const absl::Time begin = absl::Now();
  static const Steady::time_point steady_begin = Steady::now();
  return begin + absl::FromChrono(Steady::now() - steady_begin);
}

Alarm::Alarm(Clock clock, Ring ring)
    : clock_(std::move(clock)), ring_(std::move(ring)), thread_([this] { RingUntilStopped(); }) {}

Alarm::~Alarm() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
    changed_.Signal();
  }
  thread_.join();
}

void Alarm::RingBy(absl::Time time) {
  absl::MutexLock lock(&mutex_);
  if (time < next_ring_) {
    next_ring_ = time;
    changed_.Signal();
  }
}

void Alarm::RingUntilStopped() {
  mutex_.Lock();
  while (!stops_) {
    const absl::Time now = clock_();
    if (next_ring_ > now) {
      changed_.WaitWithTimeout(&mutex_, next_ring_ - now);
      continue;
    }
    next_ring_ = absl::InfiniteFuture();
    mutex_.Unlock();
    const absl::Time next = ring_(now);
    mutex_.Lock();
    next_ring_ = std::min(next_ring_, next);
  }
  mutex_.Unlock();
}

}  // namespace procgen
