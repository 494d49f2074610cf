#ifndef ENVCORE_POOL_SPIN_WAIT_H_
#define ENVCORE_POOL_SPIN_WAIT_H_

#include <thread>

namespace procgen {

// Number of polls before a thread goes to sleep, about 0.1 ms when no other thread wants the core.
// The kernel takes about as long to wake a sleeping thread (30 to 60 us in a virtual machine) as a
// small batch takes to step.
inline constexpr int kSpinIterations = 640;

// Polls `ready()` up to kSpinIterations times and yields the core between polls. It may return
// before `ready()` is true: a caller that needs the event must still wait for it.
template <typename Ready>
void SpinUntil(Ready ready) {
  for (int i = 0; i < kSpinIterations && !ready(); ++i) {
    std::this_thread::yield();
  }
}

}  // namespace procgen

#endif  // ENVCORE_POOL_SPIN_WAIT_H_
