#include "tests/benchmark/time_now.h"

#include <ctime>

namespace procgen {

namespace {

clockid_t ClockOf(TimeKind kind) {
  switch (kind) {
    case TimeKind::kThread:
      return CLOCK_THREAD_CPUTIME_ID;
    case TimeKind::kProcess:
      return CLOCK_PROCESS_CPUTIME_ID;
    case TimeKind::kWall:
      break;
  }
  return CLOCK_MONOTONIC;
}

}  // namespace

absl::Duration TimeNow(TimeKind kind) {
  timespec now = {};
  clock_gettime(ClockOf(kind), &now);
  return absl::DurationFromTimespec(now);
}

}  // namespace procgen
