#ifndef TESTS_BENCHMARK_MEASURING_RESIDENT_MEMORY_H_
#define TESTS_BENCHMARK_MEASURING_RESIDENT_MEMORY_H_

#include <cstdint>

namespace procgen {

// Returns the resident memory of this process in bytes, after returning free heap memory to the
// system. The difference of two calls is the memory that was allocated between them and not freed.
// Returns 0 on systems without /proc/self/statm.
int64_t ResidentBytes();

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_RESIDENT_MEMORY_H_
