#ifndef SERVER_POOL_QUOTA_MEMORY_TRIMMER_H_
#define SERVER_POOL_QUOTA_MEMORY_TRIMMER_H_

#include <atomic>
#include <cstdint>

#include "server/concurrency/deadline_timer.h"

namespace procgen {

// Returns free heap memory to the system, in the background.
//
// glibc keeps freed memory in several arenas. A trim takes the lock of each arena in turn, so it
// runs only after large frees, and rests on a busy machine.
// Threads: any method from any thread; none blocks.
class MemoryTrimmer {
 public:
  MemoryTrimmer();

  // Requests a trim after or before a large free. It runs within a second, or after the rest.
  void Request();

 private:
  std::atomic<int64_t> rests_until_ns_ = 0;
  DeadlineTimer timer_;  // last, so that its thread ends before what it uses
};

}  // namespace procgen

#endif  // SERVER_POOL_QUOTA_MEMORY_TRIMMER_H_
