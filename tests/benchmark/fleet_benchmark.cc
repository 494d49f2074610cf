// procgen-benchmark-fleet: rate of a fleet relative to one server, and failover pause when a node
// dies. README.md in this folder describes the counters.
#include <sys/types.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/cost.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/service/fleet/test_fleet.h"
#include "tests/service/server_process.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 256;
constexpr absl::Duration kRoundTime = absl::Milliseconds(300);
// Steps between two kills: more than half of the average number of replayed steps.
constexpr int kStepsBetweenDeaths = 200;

// CPU time of a set of processes since construction.
class CpuWatch {
 public:
  explicit CpuWatch(std::vector<pid_t> processes)
      : processes_(std::move(processes)), begin_(Now()) {}

  // CPU time per environment step, in microseconds.
  double PerStep(int64_t step_count) const {
    return absl::ToDoubleMicroseconds(Now() - begin_) / static_cast<double>(step_count);
  }

 private:
  absl::Duration Now() const {
    absl::Duration now;
    for (const pid_t process : processes_) {
      now += CpuTimeOf(process);
    }
    return now;
  }

  const std::vector<pid_t> processes_;
  const absl::Duration begin_;
};

std::string NodeName(int number) { return absl::StrCat("n", number); }

// Alternates between a fleet of `node_count` nodes and one server, with the same pool.
void RunRate(int node_count, benchmark::State& state) {
  ServerProcess single({"--address=127.0.0.1:0", "--log_level=error"});
  TestFleet fleet;
  std::vector<pid_t> nodes;
  for (int i = 0; i < node_count; ++i) {
    fleet.StartNode(NodeName(i), {"--workers=0"});
    nodes.push_back(fleet.node(NodeName(i)).process_id());
  }
  fleet.StartFleet(static_cast<size_t>(node_count));
  auto alone = RemoteLearner::Start(single.Address(), {.env_count = kEnvCount});
  auto spread = RemoteLearner::Start(fleet.address(), {.env_count = kEnvCount});
  absl::Status status = alone.status();
  status.Update(spread.status());
  Cost alone_cost;
  Cost spread_cost;
  const CpuWatch fleet_watch({fleet.fleet_process_id()});
  const CpuWatch node_watch(nodes);
  const CpuWatch single_watch({single.process_id()});
  int64_t alone_steps = 0;
  int64_t spread_steps = 0;
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      break;
    }
    status = alone_cost.MeasureRound(kRoundTime, [&] {
      alone_steps += kEnvCount;
      return (*alone)->Step();
    });
    status.Update(spread_cost.MeasureRound(kRoundTime, [&] {
      spread_steps += kEnvCount;
      return (*spread)->Step();
    }));
    state.SetIterationTime(absl::ToDoubleSeconds(2 * kRoundTime));
  }
  if (!status.ok()) {
    state.SkipWithError(status.ToString().c_str());
    return;
  }
  state.counters["single_ratio"] = absl::FDivDuration(alone_cost.wall, spread_cost.wall);
  state.counters["single_us"] = single_watch.PerStep(alone_steps);
  state.counters["fleet_us"] = fleet_watch.PerStep(spread_steps);
  state.counters["node_us"] = node_watch.PerStep(spread_steps);
  state.counters["items_per_second"] = kEnvCount / absl::ToDoubleSeconds(spread_cost.wall);
}

// In each iteration starts a node, then kills the oldest of the other three.
void RunPause(benchmark::State& state) {
  TestFleet fleet;
  int started = 0;
  for (; started < 3; ++started) {
    fleet.StartNode(NodeName(started));
  }
  fleet.StartFleet(3);
  auto learner = RemoteLearner::Start(fleet.address(), {.env_count = kEnvCount});
  absl::Status status = learner.status();
  std::vector<absl::Duration> pauses;
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      break;
    }
    fleet.StartNode(NodeName(started++));
    std::vector<absl::Duration> steps;
    for (int i = 0; i < kStepsBetweenDeaths && status.ok(); ++i) {
      const absl::Duration begin = TimeNow(TimeKind::kWall);
      status = (*learner)->Step();
      steps.push_back(TimeNow(TimeKind::kWall) - begin);
    }
    std::nth_element(steps.begin(), steps.begin() + kStepsBetweenDeaths / 2, steps.end());
    const absl::Duration usual = steps[kStepsBetweenDeaths / 2];
    fleet.KillNode(NodeName(started - 3));
    const absl::Duration begin = TimeNow(TimeKind::kWall);
    if (status.ok()) {
      status = (*learner)->Step();
    }
    const absl::Duration pause = TimeNow(TimeKind::kWall) - begin - usual;
    pauses.push_back(pause);
    state.SetIterationTime(absl::ToDoubleSeconds(pause));
  }
  if (!status.ok()) {
    state.SkipWithError(status.ToString().c_str());
    return;
  }
  std::sort(pauses.begin(), pauses.end());
  state.counters["pause_p50_ms"] = absl::ToDoubleMilliseconds(pauses[pauses.size() / 2]);
  state.counters["pause_max_ms"] = absl::ToDoubleMilliseconds(pauses.back());
}

void RegisterAll() {
  for (const int node_count : {1, 2, 3}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("fleet/rate/nodes:", node_count).c_str(),
        [node_count](benchmark::State& state) { RunRate(node_count, state); })
        ->Iterations(7)
        ->UseManualTime();
  }
  benchmark::RegisterBenchmark("fleet/pause/nodes:3", RunPause)->Iterations(15)->UseManualTime();
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, 1.0, procgen::RegisterAll);
}
