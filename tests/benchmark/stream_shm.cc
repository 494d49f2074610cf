// stream/shm/...: a learner whose pool shares memory with it, beside the pool in its own process.
#include <cstdint>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "tests/benchmark/cost.h"
#include "tests/benchmark/local_learner.h"
#include "tests/benchmark/remote_learner.h"
#include "tests/benchmark/stream_courses.h"

namespace procgen {
namespace {

class Contest {
 public:
  static absl::StatusOr<std::unique_ptr<Contest>> Start(int32_t env_count) {
    auto server = StartStreamServer();
    if (!server.ok()) {
      return server.status();
    }
    auto learner = RemoteLearner::Start(
        (*server)->address(),
        {.env_count = env_count, .requests_in_flight = kRequestsInFlight, .shares_memory = true});
    if (!learner.ok()) {
      return learner.status();
    }
    auto local =
        LocalLearner::Start({.game = kStreamGame, .worker_count = kStreamWorkerCount}, env_count);
    if (!local.ok()) {
      return local.status();
    }
    return std::unique_ptr<Contest>(
        new Contest(*std::move(server), *std::move(learner), *std::move(local)));
  }

  absl::Status RunRound() {
    absl::Status status = MeasureAhead(learner_.get(), &ours_);
    return status.ok() ? in_process_.MeasureRound(kContestantTime, [this] { return local_.Step(); })
                       : status;
  }

  void Report(int32_t env_count, benchmark::State& state) const {
    // A ratio of rates is the inverse ratio of times.
    state.counters["inprocess_ratio"] = absl::FDivDuration(in_process_.wall, ours_.wall);
    state.counters["cores_busy"] = absl::FDivDuration(ours_.cpu, ours_.wall);
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(ours_.wall);
  }

 private:
  Contest(std::unique_ptr<Server> server, std::unique_ptr<RemoteLearner> learner,
          LocalLearner local)
      : server_(std::move(server)), learner_(std::move(learner)), local_(std::move(local)) {}

  std::unique_ptr<Server> server_;
  std::unique_ptr<RemoteLearner> learner_;
  LocalLearner local_;
  Cost ours_;
  Cost in_process_;
};

}  // namespace

void RegisterSharedMemoryStreams() {
  RegisterContests<Contest>("stream/shm", {16, 64, 256, 1024, 4096});
}

}  // namespace procgen
