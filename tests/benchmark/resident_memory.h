#ifndef TESTS_BENCHMARK_RESIDENT_MEMORY_H_
#define TESTS_BENCHMARK_RESIDENT_MEMORY_H_

#include <cstdint>

namespace procgen {

// The bytes of this process that are in memory now, whole pages, after what is free was given back
// to the system: so a difference of two is what was allocated between them and not freed. 0 where
// the system does not tell (it does on Linux).
int64_t ResidentBytes();

}  // namespace procgen

#endif  // TESTS_BENCHMARK_RESIDENT_MEMORY_H_
