#ifndef ENVCORE_POOL_PATIENCE_H_
#define ENVCORE_POOL_PATIENCE_H_

#include <chrono>
#include <thread>

namespace procgen {

// How long a thread stays awake for what is about to come. A sleeper must be woken by the kernel,
// which takes about as long (30 to 60 us in a virtual machine) as a small batch of steps itself.
inline constexpr std::chrono::microseconds kPatience(100);

// Waits for `ready()` without sleeping, at most kPatience; the core goes to any other thread that
// wants it. Returns whether it came.
template <typename Ready>
bool AwaitAwake(Ready ready) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!ready()) {
    if (std::chrono::steady_clock::now() >= deadline) {
      return false;
    }
    std::this_thread::yield();
  }
  return true;
}

}  // namespace procgen

#endif  // ENVCORE_POOL_PATIENCE_H_
