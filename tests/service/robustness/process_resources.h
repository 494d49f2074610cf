#ifndef TESTS_SERVICE_ROBUSTNESS_PROCESS_RESOURCES_H_
#define TESTS_SERVICE_ROBUSTNESS_PROCESS_RESOURCES_H_

#include <sys/types.h>

#include <cstdint>

namespace procgen {

// Memory and files of a process.
struct ProcessResources {
  int64_t memory_bytes = 0;  // resident
  int64_t file_count = 0;    // open file descriptors

  static ProcessResources Of(pid_t process);
};

// Allocated bytes of this process that were not freed. Unlike resident memory, it excludes freed
// memory that allocators and sanitizers keep.
int64_t AllocatedBytes();

// Makes processes that are started later return freed memory at once, also under AddressSanitizer,
// which otherwise delays it. For tests that limit their memory.
void ReturnFreedMemoryAtOnce();

}  // namespace procgen

#endif  // TESTS_SERVICE_ROBUSTNESS_PROCESS_RESOURCES_H_
