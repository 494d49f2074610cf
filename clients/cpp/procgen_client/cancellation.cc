#include "procgen_client/cancellation.h"

#include <algorithm>

#include "absl/time/clock.h"

namespace procgen_client {

bool Cancellation::Sleep(absl::Duration duration) {
  while (duration > absl::ZeroDuration() && !Check()) {
    const absl::Duration part = std::min(duration, kCancellationInterval);
    absl::SleepFor(part);
    duration -= part;
  }
  return !Check();
}

}  // namespace procgen_client
