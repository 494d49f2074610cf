#ifndef SERVER_CONCURRENCY_CPU_THROTTLE_H_
#define SERVER_CONCURRENCY_CPU_THROTTLE_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// What the calling thread uses of its core from when this is made on, and how long it should rest
// if it is to slow nobody down. A low priority alone does not see to that: a thread that waits for
// work gives its core to whoever wants it, and gets it back some milliseconds later.
// Threads: the one that it was made on.
class CpuThrottle {
 public:
  CpuThrottle();

  // How long the thread should rest now, so that it takes 1 in 200 of the machine, but 2 s at most.
  // None where its core was not given to another against its will: then nobody wants it.
  absl::Duration RestDue() const;
  // The same after so much work, where others want the cores.
  static absl::Duration RestAfter(absl::Duration work, int core_count);

 private:
  // As the kernel counts them of the thread, from its beginning on.
  struct Counts {
    absl::Duration time;
    int64_t interruption_count = 0;
  };

  static Counts CountsNow();

  const Counts begin_;
};

}  // namespace procgen

#endif  // SERVER_CONCURRENCY_CPU_THROTTLE_H_
