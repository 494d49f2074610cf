// latency/...: one environment's round trip, compared with that of an empty message.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/learners/bare_stream.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/time_now.h"
#include "tests/benchmark/stream/stream_cases.h"

namespace procgen {
namespace {

// Each request waits for the previous response.
constexpr StreamShape kPingPong = {
    .request_bytes = 0, .response_bytes = 0, .requests_in_flight = 1};

// Durations of many round trips.
class Latencies {
 public:
  absl::Status MeasureRound(absl::FunctionRef<absl::Status()> round_trip) {
    const absl::Duration end = TimeNow(TimeKind::kWall) + kContestantTime;
    absl::Duration start = TimeNow(TimeKind::kWall);
    while (start < end) {
      if (absl::Status status = round_trip(); !status.ok()) {
        return status;
      }
      const absl::Duration now = TimeNow(TimeKind::kWall);
      times_.push_back(now - start);
      start = now;
    }
    return absl::OkStatus();
  }

  void Sort() { std::sort(times_.begin(), times_.end()); }
  // The quantile `share`, 0 to 1. REQUIRES: sorted.
  absl::Duration At(double share) const {
    return times_[static_cast<size_t>(share * static_cast<double>(times_.size() - 1))];
  }

 private:
  std::vector<absl::Duration> times_;
};

void RunLatency(int32_t env_count, benchmark::State& state) {
  const auto server = StartStreamServer();
  absl::Status status = server.status();
  absl::StatusOr<std::unique_ptr<RemoteLearner>> learner = absl::UnknownError("not started");
  if (status.ok()) {
    learner = RemoteLearner::Start((*server)->address(), {.env_count = env_count});
    status = learner.status();
  }
  const auto bare = BareStream::Start(kPingPong);
  status.Update(bare.status());
  Latencies ours;
  Latencies ping_pong;
  const auto round = [&] {
    absl::Status measured = ours.MeasureRound([&] { return (*learner)->Step(); });
    return measured.ok() ? ping_pong.MeasureRound([&] { return (*bare)->Exchange(); }) : measured;
  };
  if (RunRounds(status, round, state)) {
    ours.Sort();
    ping_pong.Sort();
    state.counters["p50_us"] = absl::ToDoubleMicroseconds(ours.At(0.5));
    state.counters["p99_us"] = absl::ToDoubleMicroseconds(ours.At(0.99));
    state.counters["pingpong_p50_us"] = absl::ToDoubleMicroseconds(ping_pong.At(0.5));
    state.counters["pingpong_ratio"] = absl::FDivDuration(ours.At(0.5), ping_pong.At(0.5));
    state.counters["pingpong_p99_ratio"] = absl::FDivDuration(ours.At(0.99), ping_pong.At(0.99));
  }
}

}  // namespace

void RegisterLatencies() {
  for (const int32_t env_count : {1, 64}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("latency/environments:", env_count).c_str(),
        [env_count](benchmark::State& state) { RunLatency(env_count, state); })
        ->UseManualTime();
  }
}

}  // namespace procgen
