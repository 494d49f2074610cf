// procgen-benchmark-tail: how long the slowest of many batches keeps a learner waiting, per game
// and mode. README.md beside this file says what the figures mean.
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
#include "tests/benchmark/benchmark_run.h"
#include "tests/benchmark/local_learner.h"
#include "tests/benchmark/time_now.h"

namespace procgen {
namespace {

constexpr int kStepCount = 10000;
constexpr int kWorkerCount = 2;

void Report(std::vector<absl::Duration> times, benchmark::State& state) {
  std::sort(times.begin(), times.end());
  const absl::Duration median = times[times.size() / 2];
  const auto ratio_at = [&](double share) {
    const auto last = static_cast<double>(times.size() - 1);
    return absl::FDivDuration(times[static_cast<size_t>(share * last)], median);
  };
  state.counters["median_us"] = absl::ToDoubleMicroseconds(median);
  state.counters["p99_ratio"] = ratio_at(0.99);
  state.counters["p999_ratio"] = ratio_at(0.999);
  state.counters["slowest_ratio"] = ratio_at(1);
}

void RunCourse(const Course& course, benchmark::State& state) {
  absl::StatusOr<LocalLearner> learner = LocalLearner::Start(course);
  absl::Status status = learner.status();
  std::vector<absl::Duration> times;
  times.reserve(kStepCount);
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    const absl::Duration start = TimeNow(TimeKind::kWall);
    status = learner->Step();
    times.push_back(TimeNow(TimeKind::kWall) - start);
  }
  if (status.ok()) {
    Report(std::move(times), state);
  }
}

void RegisterCourses() {
  for (const GameFacts& game : GameCatalog()) {
    for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
      const Course course = {std::string(game.name), mode, kWorkerCount, /*drawn=*/true};
      const std::string name = absl::StrCat("tail/", game.name, "/", DistributionModeName(mode),
                                            "/workers:", kWorkerCount);
      benchmark::RegisterBenchmark(name.c_str(), [course](benchmark::State& state) {
        RunCourse(course, state);
      })->Iterations(kStepCount);
    }
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, 0, procgen::RegisterCourses);
}
