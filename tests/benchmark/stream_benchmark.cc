// procgen-benchmark-stream: rate and latency of streams on loopback, relative to upper bounds.
// README.md in this folder describes the counters.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "server/logging/event_log.h"
#include "tests/benchmark/learners/bare_stream.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/cost.h"
#include "tests/benchmark/measuring/time_now.h"

namespace procgen {
namespace {

// Gives five rounds of the cases with three contestants, more of the others.
constexpr double kMinTimeSeconds = 3;

// Duration of one turn of a contestant.
constexpr absl::Duration kContestantTime = absl::Milliseconds(50);

// Requests in flight of a learner of stream/...: as a learner that works while the pool is stepped.
constexpr int kRequestsInFlight = 2;

// Measures one turn of a contestant that sends requests ahead.
template <typename Sender>
absl::Status MeasureAhead(Sender* sender, Cost* cost) {
  absl::Status status = sender->SendAhead();
  if (status.ok()) {
    status = cost->MeasureRound(kContestantTime, [&] { return sender->Exchange(); });
  }
  return status.ok() ? sender->ReceiveRest() : status;
}

// Runs `round`, which measures all contestants in turn, once per iteration of `state`. `status` is
// the result of the setup. Returns whether all succeeded; otherwise reports the error to `state`.
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

int64_t CoreCount() { return std::max(1U, std::thread::hardware_concurrency()); }

// The server's stream, the engine without a stream, and a stream without an engine.
class TcpContest {
 public:
  static absl::StatusOr<std::unique_ptr<TcpContest>> Start(int32_t env_count) {
    auto server = StartStreamServer();
    if (!server.ok()) {
      return server.status();
    }
    auto learner = RemoteLearner::Start(
        (*server)->address(), {.env_count = env_count, .requests_in_flight = kRequestsInFlight});
    if (!learner.ok()) {
      return learner.status();
    }
    auto wire = BareStream::Start((*learner)->Shape());
    if (!wire.ok()) {
      return wire.status();
    }
    auto engine =
        LocalLearner::Start({.game = kStreamGame, .worker_count = kStreamWorkerCount}, env_count);
    if (!engine.ok()) {
      return engine.status();
    }
    return std::unique_ptr<TcpContest>(new TcpContest(*std::move(server), *std::move(learner),
                                                      *std::move(wire), *std::move(engine)));
  }

  absl::Status RunRound() {
    absl::Status status = MeasureAhead(learner_.get(), &ours_);
    if (status.ok()) {
      status = MeasureAhead(wire_.get(), &wire_alone_);
    }
    return status.ok()
               ? engine_alone_.MeasureRound(kContestantTime, [this] { return engine_.Step(); })
               : status;
  }

  void Report(int32_t env_count, benchmark::State& state) const {
    // A ratio of rates is the inverse ratio of times.
    const absl::Duration allowed = std::max(wire_alone_.wall, engine_alone_.wall);
    const absl::Duration shared =
        std::max(allowed, (wire_alone_.cpu + engine_alone_.cpu) / CoreCount());
    state.counters["wire_ratio"] = absl::FDivDuration(wire_alone_.wall, ours_.wall);
    state.counters["engine_ratio"] = absl::FDivDuration(engine_alone_.wall, ours_.wall);
    state.counters["allowed_ratio"] = absl::FDivDuration(allowed, ours_.wall);
    state.counters["shared_allowed_ratio"] = absl::FDivDuration(shared, ours_.wall);
    state.counters["cores_busy"] = absl::FDivDuration(ours_.cpu, ours_.wall);
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(ours_.wall);
  }

 private:
  TcpContest(std::unique_ptr<Server> server, std::unique_ptr<RemoteLearner> learner,
             std::unique_ptr<BareStream> wire, LocalLearner engine)
      : server_(std::move(server)),
        learner_(std::move(learner)),
        wire_(std::move(wire)),
        engine_(std::move(engine)) {}

  std::unique_ptr<Server> server_;
  std::unique_ptr<RemoteLearner> learner_;
  std::unique_ptr<BareStream> wire_;
  LocalLearner engine_;
  Cost ours_;
  Cost wire_alone_;
  Cost engine_alone_;
};

// stream/tcp/...: a learner that sends ahead, compared with the engine alone and the wire alone.
void RegisterTcpStreams() {
  for (const int32_t env_count : {1, 16, 64, 256}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("stream/tcp/environments:", env_count).c_str(),
        [env_count](benchmark::State& state) {
          const auto contest = TcpContest::Start(env_count);
          if (RunRounds(
                  contest.status(), [&] { return (*contest)->RunRound(); }, state)) {
            (*contest)->Report(env_count, state);
          }
        })
        ->UseManualTime();
  }
}

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

// latency/...: one environment's round trip, compared with that of an empty message.
void RegisterLatencies() {
  for (const int32_t env_count : {1, 64}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("latency/environments:", env_count).c_str(),
        [env_count](benchmark::State& state) { RunLatency(env_count, state); })
        ->UseManualTime();
  }
}

void RegisterAll() {
  RegisterTcpStreams();
  RegisterLatencies();
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  procgen::SetLogLevel(procgen::LogLevel::kError);
  // As in procgen-server.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  return procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterAll);
}
