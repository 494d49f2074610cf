#ifndef ENVCORE_POOL_CREW_H_
#define ENVCORE_POOL_CREW_H_

#include <cstdint>
#include <memory>

namespace procgen {

// A crew of worker threads that steps the batches of all pools of a process.
// Threads: any method from any thread.
class Crew {
 public:
  // `thread_count` >= 0. With 0 only Pool::Step works (on the calling thread); a server wants one a
  // core.
  explicit Crew(int32_t thread_count);
  ~Crew();
};

}  // namespace procgen

#endif  // ENVCORE_POOL_CREW_H_
