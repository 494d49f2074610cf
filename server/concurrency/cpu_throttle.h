#ifndef SERVER_CONCURRENCY_CPU_THROTTLE_H_
#define SERVER_CONCURRENCY_CPU_THROTTLE_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// Measures the calling thread's CPU time from construction on, and computes how long it should rest
// so that it slows no other thread down. A low priority is not enough: a thread that blocks gives
// up its core, and waits some milliseconds to get it back from a low-priority thread.
// Threads: the constructing one.
class CpuThrottle {
 public:
  CpuThrottle();

  // How long the thread should rest now to use 0.5 % of the machine; at most 2 s. Zero if it was
  // never preempted: no other thread wants its core.
  absl::Duration RestDue() const;
  // The same after `work` of CPU time, on a contended core.
  static absl::Duration RestAfter(absl::Duration work, int core_count);

 private:
  // The kernel's counts for the thread since its start.
  struct Counts {
    absl::Duration time;
    int64_t interruption_count = 0;
  };

  static Counts CountsNow();

  const Counts begin_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_CPU_THROTTLE_H_
