#ifndef TESTS_ENVCORE_POOL_ALLOCATION_COUNT_H_
#define TESTS_ENVCORE_POOL_ALLOCATION_COUNT_H_

#include <cstdint>

namespace procgen {

// How often this process has called operator new, on any thread. A program that links this replaces
// the operator.
int64_t AllocationCount();

}  // namespace procgen

#endif  // TESTS_ENVCORE_POOL_ALLOCATION_COUNT_H_
