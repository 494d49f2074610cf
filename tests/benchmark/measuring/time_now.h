#ifndef TESTS_BENCHMARK_MEASURING_TIME_NOW_H_
#define TESTS_BENCHMARK_MEASURING_TIME_NOW_H_

#include "absl/time/time.h"

namespace procgen {

// CPU time of the calling thread, CPU time of all threads of this process, or wall time. Other load
// on the machine hardly changes CPU times; work that waits needs wall time.
enum class TimeKind { kThread, kProcess, kWall };

// The current time of `kind`, since an arbitrary fixed point.
absl::Duration TimeNow(TimeKind kind);

}  // namespace procgen

#endif  // TESTS_BENCHMARK_MEASURING_TIME_NOW_H_
