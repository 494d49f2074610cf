#include "tests/benchmark/time_now.h"

#include <ctime>

namespace procgen {

absl::Duration TimeNow(TimeKind kind) {
  timespec now = {};
  clock_gettime(kind == TimeKind::kThread ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return absl::DurationFromTimespec(now);
}

}  // namespace procgen
