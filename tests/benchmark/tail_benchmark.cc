// procgen-benchmark-tail: tail latency of batches, per game and mode. README.md in this folder
// describes the counters.
#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/time_now.h"

namespace procgen {
namespace {

constexpr size_t kStepCount = 10000;
constexpr int kRunCount = 3;
constexpr int kWorkerCount = 2;

// The quantile `share` of the sorted times, divided by the median.
double RatioAt(double share, const std::vector<absl::Duration>& sorted, absl::Duration median) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return absl::FDivDuration(sorted[static_cast<size_t>(share * last)], median);
}

// `first`: times of the first run; `least`: for each batch the minimum of all runs.
void Report(std::vector<absl::Duration> first, std::vector<absl::Duration> least,
            benchmark::State& state) {
  std::sort(first.begin(), first.end());
  std::sort(least.begin(), least.end());
  const absl::Duration median = least[kStepCount / 2];
  state.counters["median_us"] = absl::ToDoubleMicroseconds(median);
  state.counters["p99_ratio"] = RatioAt(0.99, least, median);
  state.counters["p999_ratio"] = RatioAt(0.999, least, median);
  state.counters["slowest_ratio"] = RatioAt(1, least, median);
  state.counters["first_p999_ratio"] = RatioAt(0.999, first, median);
  state.counters["first_slowest_ratio"] = RatioAt(1, first, median);
}

// Returns the times of one run. All runs have the same levels and actions.
absl::Status TimeRun(const LocalCase& local_case, benchmark::State& state,
                     std::vector<absl::Duration>* times) {
  absl::StatusOr<LocalLearner> learner = LocalLearner::Start(local_case);
  absl::Status status = learner.status();
  times->clear();
  while (status.ok() && times->size() < kStepCount && state.KeepRunning()) {
    const absl::Duration start = TimeNow(TimeKind::kWall);
    status = learner->Step();
    times->push_back(TimeNow(TimeKind::kWall) - start);
  }
  return status;
}

void RunCase(const LocalCase& local_case, benchmark::State& state) {
  std::vector<absl::Duration> first;
  absl::Status status = TimeRun(local_case, state, &first);
  std::vector<absl::Duration> least = first;
  std::vector<absl::Duration> times;
  for (int run = 1; run < kRunCount && status.ok(); ++run) {
    status = TimeRun(local_case, state, &times);
    for (size_t i = 0; i < times.size(); ++i) {
      least[i] = std::min(least[i], times[i]);
    }
  }
  if (!status.ok()) {
    state.SkipWithError(status.ToString().c_str());
    return;
  }
  state.KeepRunning();  // ends the loop: all iterations are done
  Report(std::move(first), std::move(least), state);
}

void RegisterCases() {
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
      const LocalCase local_case = {std::string(game.name), mode, kWorkerCount, /*drawn=*/true};
      const std::string name = absl::StrCat("tail/", game.name, "/", DistributionModeName(mode),
                                            "/workers:", kWorkerCount);
      benchmark::RegisterBenchmark(name.c_str(), [local_case](benchmark::State& state) {
        RunCase(local_case, state);
      })->Iterations(kRunCount * kStepCount);
    }
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, 0, procgen::RegisterCases);
}
