#include "server/concurrency/steady_time.h"

#include <algorithm>
#include <chrono>

#include "absl/time/clock.h"

namespace procgen {
namespace {

// Maximum time of one wait, so that any deadline can be expressed in nanoseconds.
constexpr absl::Duration kWaitMax = absl::Hours(1);

// absl::Mutex with the method names of the standard library.
struct LockableMutex {
  absl::Mutex* mutex;
  void lock() ABSL_NO_THREAD_SAFETY_ANALYSIS { mutex->Lock(); }      // NOLINT: standard name
  void unlock() ABSL_NO_THREAD_SAFETY_ANALYSIS { mutex->Unlock(); }  // NOLINT: standard name
};

}  // namespace

absl::Time SteadyNow() {
  using Steady = std::chrono::steady_clock;
  static const absl::Time begin = absl::Now();
  static const Steady::time_point steady_begin = Steady::now();
  return begin + absl::FromChrono(Steady::now() - steady_begin);
}

bool SteadyCondVar::WaitUntil(absl::Mutex* mutex, absl::Time deadline) {
  const absl::Duration wait = deadline - SteadyNow();
  if (wait <= absl::ZeroDuration()) {
    return false;
  }
  LockableMutex lock{mutex};
  changed_.wait_for(lock, absl::ToChronoNanoseconds(std::min(wait, kWaitMax)));
  return true;
}

void SteadyNotification::Notify() {
  absl::MutexLock lock(&mutex_);
  notified_ = true;
  changed_.NotifyAll();
}

bool SteadyNotification::HasBeenNotified() const {
  absl::MutexLock lock(&mutex_);
  return notified_;
}

bool SteadyNotification::WaitWithTimeout(absl::Duration timeout) const {
  absl::MutexLock lock(&mutex_);
  return changed_.AwaitUntil(&mutex_, SteadyNow() + timeout,
                             [this]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return notified_; });
}

}  // namespace procgen
