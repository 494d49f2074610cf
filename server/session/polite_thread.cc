#include "server/session/polite_thread.h"

#include <sys/resource.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "server/session/alarm.h"

namespace procgen {
namespace {

// The least that a thread can have of a busy machine.
constexpr int kNicenessMax = 19;
constexpr int kPartOfMachine = 200;

// What this thread has used of its core, and how often another was given it instead.
struct Usage {
  absl::Duration time;
  int64_t interruption_count = 0;
};

Usage UsageNow() {
  rusage usage = {};
  getrusage(RUSAGE_THREAD, &usage);
  return {absl::DurationFromTimeval(usage.ru_utime) + absl::DurationFromTimeval(usage.ru_stime),
          usage.ru_nivcsw};
}

}  // namespace

PoliteThread::PoliteThread() {
  // On Linux that is said of a thread. Where it is refused, it costs the others more.
  crew_.Run([] { setpriority(PRIO_PROCESS, 0, kNicenessMax); });
}

void PoliteThread::Run(absl::AnyInvocable<void()> work) {
  crew_.Run([this, work = std::move(work)]() mutable {
    const Usage before = UsageNow();
    work();
    const Usage after = UsageNow();
    if (after.interruption_count > before.interruption_count) {
      const auto core_count = static_cast<int>(std::thread::hardware_concurrency());
      rests_until_ns_ =
          absl::ToUnixNanos(SteadyNow() + RestAfter(after.time - before.time, core_count));
    }
  });
}

absl::Duration PoliteThread::RestAfter(absl::Duration work, int core_count) {
  return work * std::max(0, kPartOfMachine / std::max(1, core_count) - 1);
}

}  // namespace procgen
