// procgen-benchmark-engine: the cost of a step in process, per game and mode, with and without
// drawing, by one and by two workers. README.md beside this file says what the figures mean.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/crew.h"
#include "envcore/pool/pool.h"
#include "tests/benchmark/action_tape.h"
#include "tests/benchmark/benchmark_run.h"
#include "tests/benchmark/released_costs.h"
#include "tests/benchmark/round_clock.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 64;
// Steps that bring the environments from their common start to a typical mixture of states.
constexpr int kWarmUpSteps = 100;
// Seven rounds, as the released engine was measured.
constexpr double kMinTimeSeconds = 2.1;

struct Course {
  std::string game;
  DistributionMode mode = DistributionMode::kEasy;
  int worker_count = 1;  // the calling thread is one of them
  bool drawn = true;

  std::string Name() const {
    return absl::StrCat("step/", game, "/", DistributionModeName(mode), "/workers:", worker_count,
                        "/drawn:", drawn ? 1 : 0);
  }
};

// A pool and what a learner gives it and takes from it.
class Learner {
 public:
  Learner(std::unique_ptr<Pool> pool, bool drawn)
      : pool_(std::move(pool)),
        actions_(kEnvCount),
        observations_(drawn ? static_cast<size_t>(kEnvCount) * kObservationBytes : 0) {}

  absl::Status Step() {
    const StepInput input = {.first = 0, .count = kEnvCount, .actions = actions_.Next()};
    Batch batch;
    batch.observations = absl::MakeSpan(observations_);
    batch.rewards = absl::MakeSpan(rewards_);
    batch.first = absl::MakeSpan(first_);
    return pool_->Step(input, batch);
  }

 private:
  std::unique_ptr<Pool> pool_;
  ActionTape actions_;
  std::vector<uint8_t> observations_;
  std::array<float, kEnvCount> rewards_ = {};
  std::array<uint8_t, kEnvCount> first_ = {};
};

absl::StatusOr<Learner> MakeLearner(const Course& course) {
  PoolOptions options;
  options.games = {course.game};
  options.env_count = kEnvCount;
  options.environment.distribution_mode = course.mode;
  auto pool = Pool::Create(options, std::make_shared<Crew>(course.worker_count - 1));
  if (!pool.ok()) {
    return pool.status();
  }
  Learner learner(*std::move(pool), course.drawn);
  for (int step = 0; step < kWarmUpSteps; ++step) {
    if (absl::Status status = learner.Step(); !status.ok()) {
      return status;
    }
  }
  return learner;
}

void Report(const Course& course, const RoundClock& clock, benchmark::State& state) {
  const double units = clock.BestInUnits() / kEnvCount;
  state.counters["yardstick_units"] = units;
  // Without drawing, nothing of the released engine's is comparable.
  if (const auto released = ReleasedCost(course.game, course.mode); released && course.drawn) {
    state.counters["released_ratio"] = units / *released;
  }
  state.counters["items_per_second"] = kEnvCount / absl::ToDoubleSeconds(clock.Best());
}

void RunCourse(const Course& course, benchmark::State& state) {
  absl::StatusOr<Learner> learner = MakeLearner(course);
  absl::Status status = learner.status();
  // One worker is the calling thread; then the figure need not suffer from what else runs here.
  RoundClock clock(course.worker_count == 1 ? TimeKind::kThread : TimeKind::kWall);
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
    Report(course, clock, state);
  }
}

void RegisterCourses() {
  for (const GameFacts& game : GameCatalog()) {
    for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
      for (const int worker_count : {1, 2}) {
        for (const bool drawn : {false, true}) {
          const Course course = {std::string(game.name), mode, worker_count, drawn};
          benchmark::RegisterBenchmark(course.Name().c_str(), [course](benchmark::State& state) {
            RunCourse(course, state);
          });
        }
      }
    }
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterCourses);
}
