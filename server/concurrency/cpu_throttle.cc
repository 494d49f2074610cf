#include "server/concurrency/cpu_throttle.h"

#include <sys/resource.h>

#include <algorithm>
#include <thread>

namespace procgen {
namespace {

constexpr int kPartOfMachine = 200;
constexpr absl::Duration kRestMax = absl::Seconds(2);

}  // namespace

CpuThrottle::CpuThrottle() : begin_(CountsNow()) {}

absl::Duration CpuThrottle::RestDue() const {
  const Counts now = CountsNow();
  if (now.interruption_count == begin_.interruption_count) {
    return absl::ZeroDuration();
  }
  return RestAfter(now.time - begin_.time, static_cast<int>(std::thread::hardware_concurrency()));
}

absl::Duration CpuThrottle::RestAfter(absl::Duration work, int core_count) {
  return std::min(work * std::max(0, kPartOfMachine / std::max(1, core_count) - 1), kRestMax);
}

CpuThrottle::Counts CpuThrottle::CountsNow() {
  rusage usage = {};
  getrusage(RUSAGE_THREAD, &usage);
  return {absl::DurationFromTimeval(usage.ru_utime) + absl::DurationFromTimeval(usage.ru_stime),
          usage.ru_nivcsw};
}

}  // namespace procgen
