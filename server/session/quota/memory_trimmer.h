#ifndef SERVER_SESSION_QUOTA_MEMORY_TRIMMER_H_
#define SERVER_SESSION_QUOTA_MEMORY_TRIMMER_H_

#include <atomic>
#include <cstdint>

#include "server/concurrency/deadline_timer.h"

namespace procgen {

// Returns free memory of the heap to the system, in the background.
//
// glibc keeps what is freed, in several arenas. A trim takes the lock of each arena in turn, so it
// runs after large frees only, and rests where others want its core.
// Threads: any method from any thread; none blocks.
class MemoryTrimmer {
 public:
  MemoryTrimmer();

  // Much was freed, or will be at once: trims within a second, or when it has rested.
  void Request();

 private:
  std::atomic<int64_t> rests_until_ns_ = 0;
  DeadlineTimer timer_;  // last, so that its thread ends before what it uses
};

}  // namespace procgen

#endif  // SERVER_SESSION_QUOTA_MEMORY_TRIMMER_H_
