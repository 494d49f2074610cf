// procgen-benchmark-create: time to create a large pool and memory of its environments, per game
// and mode. README.md in this folder describes the counters.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/worker_pool.h"
#include "tests/benchmark/measuring/action_script.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/resident_memory.h"
#include "tests/benchmark/measuring/round_clock.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 10000;
// Environments stepped at a time, so that the batch is small.
constexpr int32_t kSliceCount = 100;
// Enough to allocate all state that an environment keeps between steps.
constexpr int kPlayedSteps = 20;
// One round, so that fast games are created several times.
constexpr double kMinTimeSeconds = 0.3;

absl::StatusOr<std::unique_ptr<Pool>> MakePool(const std::string& game, DistributionMode mode,
                                               int32_t env_count) {
  PoolOptions options;
  options.games = {game};
  options.env_count = env_count;
  options.environment.distribution_mode = mode;
  return Pool::Create(options, std::make_shared<WorkerPool>(0));
}

// Steps and draws all environments kPlayedSteps times.
absl::Status Play(Pool* pool) {
  ActionScript actions(kSliceCount);
  std::vector<uint8_t> observations(size_t{kSliceCount} * pool->observation_bytes());
  Batch batch;
  batch.observations = absl::MakeSpan(observations);
  absl::Status status;
  for (int step = 0; step < kPlayedSteps; ++step) {
    for (int32_t first = 0; first < kEnvCount; first += kSliceCount) {
      status.Update(
          pool->Step({.first = first, .count = kSliceCount, .actions = actions.Next()}, batch));
    }
  }
  return status;
}

void RunCase(const std::string& game, DistributionMode mode, benchmark::State& state) {
  // Load the art first: all pools of a game share it, so it does not count.
  const auto small_pool = MakePool(game, mode, 1);
  absl::Status status = small_pool.status();
  int64_t bytes = 0;
  int64_t played_bytes = 0;
  RoundClock clock(TimeKind::kThread);
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    state.PauseTiming();
    const int64_t bytes_before = ResidentBytes();
    bool round_is_over = false;
    {
      state.ResumeTiming();
      clock.Start();
      const auto pool = MakePool(game, mode, kEnvCount);
      round_is_over = clock.Lap();
      state.PauseTiming();
      bytes = ResidentBytes() - bytes_before;
      status = pool.status();
      if (status.ok() && played_bytes == 0) {
        status = Play(pool->get());
        played_bytes = ResidentBytes() - bytes_before;
      }
    }
    if (round_is_over) {
      clock.MeasureUnit();
    }
    state.ResumeTiming();
  }
  if (status.ok()) {
    clock.MeasureUnit();
    state.counters["bytes_per_environment"] = static_cast<double>(bytes) / kEnvCount;
    state.counters["bytes_per_played_environment"] = static_cast<double>(played_bytes) / kEnvCount;
    state.counters["yardstick_units"] = clock.BestInUnits() / kEnvCount;
    state.counters["seconds"] = absl::ToDoubleSeconds(clock.Best());
  }
}

void RegisterCases() {
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
      const std::string name = absl::StrCat("create/", game.name, "/", DistributionModeName(mode),
                                            "/environments:", kEnvCount);
      benchmark::RegisterBenchmark(name.c_str(), [&game, mode](benchmark::State& state) {
        RunCase(std::string(game.name), mode, state);
      })->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  return procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterCases);
}
