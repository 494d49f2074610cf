#ifndef TESTS_WALL_CLOCK_WALL_CLOCK_H_
#define TESTS_WALL_CLOCK_WALL_CLOCK_H_

#include <cstdint>

namespace procgen {

// Moves CLOCK_REALTIME of this process by `nanoseconds` relative to the machine. Threads: any.
void SetWallClockOffset(int64_t nanoseconds);

}  // namespace procgen

#endif  // TESTS_WALL_CLOCK_WALL_CLOCK_H_
