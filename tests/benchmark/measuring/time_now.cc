#include "tests/benchmark/measuring/time_now.h"

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

absl::Duration TimeOf(clockid_t clock) {
  timespec now = {};
  clock_gettime(clock, &now);
  return absl::DurationFromTimespec(now);
}

}  // namespace

absl::Duration TimeNow(TimeKind kind) { return TimeOf(ClockOf(kind)); }

absl::Duration CpuTimeOf(pid_t process) {
  clockid_t clock = {};
  clock_getcpuclockid(process, &clock);
  return TimeOf(clock);
}

}  // namespace procgen
