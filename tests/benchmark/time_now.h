#ifndef TESTS_BENCHMARK_TIME_NOW_H_
#define TESTS_BENCHMARK_TIME_NOW_H_

#include <sys/types.h>

#include "absl/time/time.h"

namespace procgen {

// Which time counts: what the calling thread spent computing, or all threads of this process, which
// others on the machine hardly change; or what went by, for work that waits.
enum class TimeKind { kThread, kProcess, kWall };

// The time of `kind` now, since some fixed moment.
absl::Duration TimeNow(TimeKind kind);

// What all threads of another process have spent computing. REQUIRES: it is there.
absl::Duration CpuTimeOf(pid_t process);

}  // namespace procgen

#endif  // TESTS_BENCHMARK_TIME_NOW_H_
