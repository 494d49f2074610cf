// stream/shm/...: a learner with a pool in shared memory, compared with a pool in process, alone
// and with a bare exchange of messages after each step. stream/shm/GAME/...: the same for each
// game.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "tests/benchmark/learners/bare_pipes.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/learners/remote_learner.h"
#include "tests/benchmark/measuring/cost.h"
#include "tests/benchmark/stream/stream_cases.h"

namespace procgen {
namespace {

// Environments in the pool of each game.
constexpr int32_t kGameEnvironments = 64;

// About the size of a response: the numbers of the request and of the batch.
constexpr size_t kAnswerBytes = 16;

class ShmContest {
 public:
  static absl::StatusOr<std::unique_ptr<ShmContest>> Start(int32_t env_count,
                                                           const std::string& game = kStreamGame) {
    auto server = StartStreamServer();
    if (!server.ok()) {
      return server.status();
    }
    auto learner =
        RemoteLearner::Start((*server)->address(), {.game = game,
                                                    .env_count = env_count,
                                                    .requests_in_flight = kRequestsInFlight,
                                                    .shares_memory = true});
    if (!learner.ok()) {
      return learner.status();
    }
    // As the learner gets: all arrays, and one batch to read while the next is written.
    LocalCase local_case = {.game = game, .worker_count = kStreamWorkerCount};
    local_case.batch_count = kRequestsInFlight;
    local_case.answers_all = true;
    auto local = LocalLearner::Start(local_case, env_count);
    if (!local.ok()) {
      return local.status();
    }
    auto pipes = BarePipes::Start((*learner)->Shape().request_bytes, kAnswerBytes);
    if (!pipes.ok()) {
      return pipes.status();
    }
    return std::unique_ptr<ShmContest>(new ShmContest(*std::move(server), *std::move(learner),
                                                      *std::move(local), *std::move(pipes)));
  }

  absl::Status RunRound() {
    absl::Status status = MeasureAhead(learner_.get(), &ours_);
    if (status.ok()) {
      status = in_process_.MeasureRound(kContestantTime, [this] { return local_.Step(); });
    }
    return status.ok()
               ? exchanging_.MeasureRound(kContestantTime, [this] { return StepAndExchange(); })
               : status;
  }

  void Report(int32_t env_count, benchmark::State& state) const {
    // A ratio of rates is the inverse ratio of times.
    state.counters["inprocess_ratio"] = absl::FDivDuration(in_process_.wall, ours_.wall);
    state.counters["exchanging_ratio"] = absl::FDivDuration(exchanging_.wall, ours_.wall);
    state.counters["cores_busy"] = absl::FDivDuration(ours_.cpu, ours_.wall);
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(ours_.wall);
  }

 private:
  ShmContest(std::unique_ptr<Server> server, std::unique_ptr<RemoteLearner> learner,
             LocalLearner local, std::unique_ptr<BarePipes> pipes)
      : server_(std::move(server)),
        learner_(std::move(learner)),
        local_(std::move(local)),
        pipes_(std::move(pipes)) {}

  absl::Status StepAndExchange() {
    absl::Status status = local_.Step();
    return status.ok() ? pipes_->Exchange() : status;
  }

  std::unique_ptr<Server> server_;
  std::unique_ptr<RemoteLearner> learner_;
  LocalLearner local_;
  std::unique_ptr<BarePipes> pipes_;
  Cost ours_;
  Cost in_process_;
  Cost exchanging_;
};

}  // namespace

void RegisterSharedMemoryStreams() {
  RegisterContests<ShmContest>("stream/shm", {16, 64, 256, 1024, 4096});
  for (const GameSpec& game : GameCatalog()) {
    RegisterContest(absl::StrCat("stream/shm/", game.name), kGameEnvironments,
                    [name = std::string(game.name)](int32_t env_count) {
                      return ShmContest::Start(env_count, name);
                    });
  }
}

}  // namespace procgen
