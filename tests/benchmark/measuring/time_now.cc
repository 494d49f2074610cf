#include "tests/benchmark/measuring/time_now.h"

#include <ctime>

namespace procgen {

absl::Duration TimeNow(TimeKind kind) {
  timespec now = {};
  clock_gettime(kind == TimeKind::kThread    ? CLOCK_THREAD_CPUTIME_ID
                : kind == TimeKind::kProcess ? CLOCK_PROCESS_CPUTIME_ID
                                             : CLOCK_MONOTONIC,
                &now);
  return absl::DurationFromTimespec(now);
}

}  // namespace procgen
