#include "server/pool/quota/memory_trimmer.h"

#include <malloc.h>

#include <algorithm>

#include "server/concurrency/cpu_throttle.h"
#include "server/concurrency/steady_time.h"

namespace procgen {
namespace {

constexpr absl::Duration kDelay = absl::Seconds(1);

}  // namespace

MemoryTrimmer::MemoryTrimmer()
    : timer_(SteadyNow, [this](absl::Time /*now*/) {
        const CpuThrottle throttle;
        malloc_trim(0);
        rests_until_ns_ = absl::ToUnixNanos(SteadyNow() + throttle.RestDue());
        return absl::InfiniteFuture();
      }) {}

void MemoryTrimmer::Request() {
  timer_.ArmBy(std::max(SteadyNow() + kDelay, absl::FromUnixNanos(rests_until_ns_)));
}

}  // namespace procgen
