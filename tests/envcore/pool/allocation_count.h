#ifndef TESTS_ENVCORE_POOL_ALLOCATION_COUNT_H_
#define TESTS_ENVCORE_POOL_ALLOCATION_COUNT_H_

#include <cstdint>

namespace procgen {

// The number of calls of operator new in this process, on all threads. Linking this file replaces
// operator new.
int64_t AllocationCount();

}  // namespace procgen

#endif  // TESTS_ENVCORE_POOL_ALLOCATION_COUNT_H_
