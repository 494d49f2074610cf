// step/...: a learner that waits for each answer, whose pool is stepped in several slices, beside
// one whose pool is stepped as a whole.
#include <cstdint>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/cost.h"
#include "tests/benchmark/remote_learner.h"
#include "tests/benchmark/stream_cases.h"

namespace procgen {
namespace {

void RunPipeline(int32_t env_count, int32_t pipeline, benchmark::State& state) {
  const auto server = StartStreamServer();
  absl::Status status = server.status();
  std::unique_ptr<RemoteLearner> whole;
  std::unique_ptr<RemoteLearner> sliced;
  const auto start = [&](int32_t slices, std::unique_ptr<RemoteLearner>* learner) {
    if (status.ok()) {
      auto started =
          RemoteLearner::Start((*server)->address(), {.env_count = env_count, .pipeline = slices});
      status = started.status();
      if (status.ok()) {
        *learner = *std::move(started);
      }
    }
  };
  start(1, &whole);
  start(pipeline, &sliced);
  Cost whole_cost;
  Cost sliced_cost;
  const auto round = [&] {
    absl::Status measured = whole_cost.MeasureRound(kContestantTime, [&] { return whole->Step(); });
    return measured.ok() ? sliced_cost.MeasureRound(kContestantTime, [&] { return sliced->Step(); })
                         : measured;
  };
  if (RunRounds(status, round, state)) {
    state.counters["pipeline_ratio"] = absl::FDivDuration(whole_cost.wall, sliced_cost.wall);
    state.counters["slice_cpu_us"] =
        absl::ToDoubleMicroseconds(sliced_cost.cpu - whole_cost.cpu) / (pipeline - 1);
    state.counters["step_us"] = absl::ToDoubleMicroseconds(sliced_cost.wall);
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(sliced_cost.wall);
  }
}

}  // namespace

void RegisterPipelines() {
  for (const int32_t env_count : {16, 32, 64, 128, 256}) {
    for (const int32_t pipeline : {2, 4}) {
      benchmark::RegisterBenchmark(
          absl::StrCat("step/environments:", env_count, "/pipeline:", pipeline).c_str(),
          [env_count, pipeline](benchmark::State& state) {
            RunPipeline(env_count, pipeline, state);
          })
          ->UseManualTime();
    }
  }
}

}  // namespace procgen
