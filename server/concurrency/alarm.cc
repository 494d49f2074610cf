#include "server/concurrency/alarm.h"

#include <algorithm>
#include <utility>

namespace procgen {

Alarm::Alarm(Clock clock, Ring ring)
    : clock_(std::move(clock)), ring_(std::move(ring)), thread_([this] { RingUntilStopped(); }) {}

Alarm::~Alarm() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
    changed_.notify_one();
  }
  thread_.join();
}

void Alarm::RingBy(absl::Time time) {
  const std::lock_guard lock(mutex_);
  if (time < next_ring_) {
    next_ring_ = time;
    changed_.notify_one();
  }
}

void Alarm::RingUntilStopped() {
  std::unique_lock lock(mutex_);
  while (!stops_) {
    const absl::Time now = clock_();
    if (next_ring_ == absl::InfiniteFuture()) {
      changed_.wait(lock);
      continue;
    }
    if (next_ring_ > now) {
      changed_.wait_for(lock, absl::ToChronoNanoseconds(next_ring_ - now));
      continue;
    }
    next_ring_ = absl::InfiniteFuture();
    lock.unlock();
    const absl::Time next = ring_(now);
    lock.lock();
    next_ring_ = std::min(next_ring_, next);
  }
}

}  // namespace procgen
