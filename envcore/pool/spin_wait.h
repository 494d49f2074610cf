#ifndef ENVCORE_POOL_SPIN_WAIT_H_
#define ENVCORE_POOL_SPIN_WAIT_H_

#include <thread>

namespace procgen {

// How often a thread looks for what is about to come before it goes to sleep: about 0.1 ms where
// nobody else wants its core. A sleeper must be woken by the kernel, which takes about as long (30
// to 60 us in a virtual machine) as a small batch of steps itself.
inline constexpr int kSpinIterations = 640;

// Looks whether `ready()` without sleeping, for a moment; the core goes to any other thread that
// wants it. Who must be sure that it is ready still has to wait.
template <typename Ready>
void SpinUntil(Ready ready) {
  for (int i = 0; i < kSpinIterations && !ready(); ++i) {
    std::this_thread::yield();
  }
}

}  // namespace procgen

#endif  // ENVCORE_POOL_SPIN_WAIT_H_
