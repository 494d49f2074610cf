// procgen-benchmark-engine: cost of a step in process, per game and mode, with and without drawing,
// with one and two workers. README.md in this folder describes the counters.
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "tests/benchmark/benchmark_run.h"
#include "tests/benchmark/local_learner.h"
#include "tests/benchmark/round_clock.h"
#include "tests/benchmark/upstream_costs.h"

namespace procgen {
namespace {

// Seven rounds, as Procgen 0.10.7 was measured.
constexpr double kMinTimeSeconds = 2.1;

std::string NameOf(const LocalCase& local_case) {
  return absl::StrCat("step/", local_case.game, "/", DistributionModeName(local_case.mode),
                      "/workers:", local_case.worker_count, "/drawn:", local_case.drawn ? 1 : 0);
}

void Report(const LocalCase& local_case, const RoundClock& clock, benchmark::State& state) {
  const double units = clock.BestInUnits() / LocalLearner::kEnvCount;
  state.counters["yardstick_units"] = units;
  // Upstream always draws, so there is no reference without drawing.
  if (const auto upstream_cost = UpstreamCost(local_case.game, local_case.mode);
      upstream_cost && local_case.drawn) {
    state.counters["upstream_ratio"] = units / *upstream_cost;
  }
  state.counters["items_per_second"] =
      LocalLearner::kEnvCount / absl::ToDoubleSeconds(clock.Best());
}

void RunCase(const LocalCase& local_case, benchmark::State& state) {
  absl::StatusOr<LocalLearner> learner = LocalLearner::Start(local_case);
  absl::Status status = learner.status();
  // One worker is the calling thread: its CPU time is independent of other load.
  RoundClock clock(local_case.worker_count == 1 ? TimeKind::kThread : TimeKind::kWall);
  clock.Start();
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    status = learner->Step();
    if (clock.Lap()) {
      state.PauseTiming();
      clock.MeasureUnit();
      state.ResumeTiming();
      clock.Start();
    }
  }
  if (status.ok()) {
    clock.MeasureUnit();
    Report(local_case, clock, state);
  }
}

void RegisterCases() {
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
      for (const int worker_count : {1, 2}) {
        for (const bool drawn : {false, true}) {
          const LocalCase local_case = {std::string(game.name), mode, worker_count, drawn};
          benchmark::RegisterBenchmark(
              NameOf(local_case).c_str(),
              [local_case](benchmark::State& state) { RunCase(local_case, state); });
        }
      }
    }
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterCases);
}
