#ifndef TESTS_SERVICE_ROBUSTNESS_PROCESS_RESOURCES_H_
#define TESTS_SERVICE_ROBUSTNESS_PROCESS_RESOURCES_H_

#include <sys/types.h>

#include <cstdint>

namespace procgen {

// What a process holds.
struct ProcessResources {
  int64_t memory_bytes = 0;  // resident
  int64_t file_count = 0;    // open file descriptors

  static ProcessResources Of(pid_t process);
};

// What this process has allocated and not freed. Unlike resident memory without what allocators and
// sanitizers hold back of what was freed.
int64_t AllocatedBytes();

// Has processes that are started from now on give back at once what they free, under
// AddressSanitizer, too, which otherwise holds it back for long. For tests that judge their memory.
void ReturnFreedMemoryAtOnce();

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_PROCESS_RESOURCES_H_
