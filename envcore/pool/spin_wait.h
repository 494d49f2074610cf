#ifndef ENVCORE_POOL_SPIN_WAIT_H_
#define ENVCORE_POOL_SPIN_WAIT_H_

#include <atomic>
#include <condition_variable>
#include <mutex>

namespace procgen {

// Number of polls before a thread goes to sleep: 30 to 100 us, by processor. The kernel takes about
// as long to wake a sleeping thread (30 to 60 us in a virtual machine) as a small batch takes to
// step.
inline constexpr int kSpinIterations = 2000;

// Lets a polling thread leave the processor's units to the other thread of its core.
inline void RelaxProcessor() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("isb");  // `yield` does nothing on most processors
#endif
}

// Polls `ready()` up to kSpinIterations times. It may return before `ready()` is true: a caller
// that needs the event must still wait for it. The thread keeps its core meanwhile: a thread that
// yields gives its time to other programs, and gets half of its share on a busy machine.
template <typename Ready>
void SpinUntil(Ready ready) {
  for (int i = 0; i < kSpinIterations && !ready(); ++i) {
    RelaxProcessor();
  }
}

// An event that happens once; its setter may be another thread.
class CompletionEvent {
 public:
  CompletionEvent() = default;
  // Waits until Set has left the object.
  ~CompletionEvent() { const std::lock_guard lock(mutex_); }
  CompletionEvent(const CompletionEvent&) = delete;
  CompletionEvent& operator=(const CompletionEvent&) = delete;

  void Set() {
    const std::lock_guard lock(mutex_);
    is_set_.store(true, std::memory_order_release);
    was_set_.notify_one();
  }

  void Wait() {
    SpinUntil([this] { return is_set_.load(std::memory_order_acquire); });
    if (!is_set_.load(std::memory_order_acquire)) {
      std::unique_lock lock(mutex_);
      was_set_.wait(lock, [this] { return is_set_.load(std::memory_order_relaxed); });
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable was_set_;
  std::atomic<bool> is_set_ = false;
};

}  // namespace procgen

#endif  // ENVCORE_POOL_SPIN_WAIT_H_
