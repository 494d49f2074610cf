// step/...: a learner that waits for each response and whose pool is stepped in several chunks,
// compared with a pool that is stepped as a whole.
#include <cstdint>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/cost.h"
#include "tests/benchmark/stream/stream_cases.h"

namespace procgen {
namespace {

void RunChunks(int32_t env_count, int32_t chunk_count, benchmark::State& state) {
  const auto server = StartStreamServer();
  absl::Status status = server.status();
  std::unique_ptr<RemoteLearner> whole;
  std::unique_ptr<RemoteLearner> chunked;
  const auto start = [&](int32_t count, std::unique_ptr<RemoteLearner>* learner) {
    if (status.ok()) {
      auto started = RemoteLearner::Start((*server)->address(),
                                          {.env_count = env_count, .chunk_count = count});
      status = started.status();
      if (status.ok()) {
        *learner = *std::move(started);
      }
    }
  };
  start(1, &whole);
  start(chunk_count, &chunked);
  Cost whole_cost;
  Cost chunked_cost;
  const auto round = [&] {
    absl::Status measured = whole_cost.MeasureRound(kContestantTime, [&] { return whole->Step(); });
    return measured.ok()
               ? chunked_cost.MeasureRound(kContestantTime, [&] { return chunked->Step(); })
               : measured;
  };
  if (RunRounds(status, round, state)) {
    state.counters["chunk_ratio"] = absl::FDivDuration(whole_cost.wall, chunked_cost.wall);
    state.counters["chunk_cpu_us"] =
        absl::ToDoubleMicroseconds(chunked_cost.cpu - whole_cost.cpu) / (chunk_count - 1);
    state.counters["step_us"] = absl::ToDoubleMicroseconds(chunked_cost.wall);
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(chunked_cost.wall);
  }
}

}  // namespace

void RegisterChunks() {
  for (const int32_t env_count : {16, 32, 64, 128, 256}) {
    for (const int32_t chunk_count : {2, 4}) {
      benchmark::RegisterBenchmark(
          absl::StrCat("step/environments:", env_count, "/chunks:", chunk_count).c_str(),
          [env_count, chunk_count](benchmark::State& state) {
            RunChunks(env_count, chunk_count, state);
          })
          ->UseManualTime();
    }
  }
}

}  // namespace procgen
