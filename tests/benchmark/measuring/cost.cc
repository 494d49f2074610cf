#include "tests/benchmark/measuring/cost.h"

#include <algorithm>

#include "tests/benchmark/measuring/time_now.h"

namespace procgen {

absl::Status Cost::MeasureRound(absl::Duration round, absl::FunctionRef<absl::Status()> work) {
  const absl::Duration wall_start = TimeNow(TimeKind::kWall);
  const absl::Duration cpu_start = TimeNow(TimeKind::kProcess);
  absl::Duration elapsed;
  int count = 0;
  while (elapsed < round) {
    if (absl::Status status = work(); !status.ok()) {
      return status;
    }
    ++count;
    elapsed = TimeNow(TimeKind::kWall) - wall_start;
  }
  wall = std::min(wall, elapsed / count);
  cpu = std::min(cpu, (TimeNow(TimeKind::kProcess) - cpu_start) / count);
  return absl::OkStatus();
}

}  // namespace procgen
