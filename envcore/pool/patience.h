#ifndef ENVCORE_POOL_PATIENCE_H_
#define ENVCORE_POOL_PATIENCE_H_

#include <chrono>
#include <thread>

namespace procgen {

// How often a thread looks for what is about to come before it goes to sleep: about 0.1 ms. A
// sleeper must be woken by the kernel, which takes about as long (30 to 60 us in a virtual machine)
// as a small batch of steps itself.
inline constexpr int kLooksBeforeSleep = 256;

// Looks whether `ready()` without sleeping, for a moment; the core goes to any other thread that
// wants it. Who must be sure that it is ready still has to wait.
template <typename Ready>
void AwaitAwake(Ready ready) {
  for (int looks = 0; looks < kLooksBeforeSleep && !ready(); ++looks) {
    std::this_thread::yield();
  }
}

// The patience of a thread that waits again and again: it stays awake for what comes soon, and goes
// to sleep at once where the last time it waited in vain. Where work comes at the pace of a
// network, the looks would only take the core, for moments, from whoever sends and receives.
// Threads: compatible (one at a time).
class Patience {
 public:
  // Begins to wait, as AwaitAwake, if that promises anything.
  template <typename Ready>
  void Await(Ready ready) {
    begin_ = Clock::now();
    if (was_short_) {
      AwaitAwake(ready);
    }
  }
  // What was waited for, awake or asleep, is there.
  void EndWait() { was_short_ = Clock::now() - begin_ < kShort; }

 private:
  using Clock = std::chrono::steady_clock;
  // More than the looks take, so that who slept for a moment only looks the next time.
  static constexpr std::chrono::microseconds kShort{200};

  Clock::time_point begin_;
  bool was_short_ = true;  // the last wait
};

}  // namespace procgen

#endif  // ENVCORE_POOL_PATIENCE_H_
