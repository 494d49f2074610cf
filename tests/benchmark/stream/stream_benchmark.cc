// procgen-benchmark-stream: rate, latency and fairness of streams on loopback, relative to upper
// bounds. README.md in the folder above describes the counters.
#include <string>
#include <utility>

#include "absl/synchronization/mutex.h"
#include "server/logging/event_log.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/benchmark/stream/stream_cases.h"

namespace procgen {
namespace {

// Gives five rounds of the cases with three contestants, more of the others.
constexpr double kMinTimeSeconds = 3;

void RegisterAll() {
  RegisterTcpStreams();
  RegisterLatencies();
  RegisterFairness();
}

}  // namespace

bool RunRounds(absl::Status status, absl::FunctionRef<absl::Status()> round,
               benchmark::State& state) {
  for ([[maybe_unused]] const auto iteration : state) {
    const absl::Duration start = TimeNow(TimeKind::kWall);
    if (status.ok()) {
      status = round();
    }
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    state.SetIterationTime(absl::ToDoubleSeconds(TimeNow(TimeKind::kWall) - start));
  }
  return status.ok();
}

}  // namespace procgen

int main(int argc, char** argv) {
  procgen::SetLogLevel(procgen::LogLevel::kError);
  // As in procgen-server.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  return procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterAll);
}
