// stream/tcp/...: a learner that sends ahead, compared with the engine alone and the wire alone.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/learners/bare_stream.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/cost.h"
#include "tests/benchmark/stream/stream_cases.h"

namespace procgen {
namespace {

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

}  // namespace

void RegisterTcpStreams() { RegisterContests<TcpContest>("stream/tcp", {1, 16, 64, 256}); }

}  // namespace procgen
