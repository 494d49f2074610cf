#include "tests/benchmark/shared_memory_benchmark.h"

#include <algorithm>
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
#include "envcore/pool/pool.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/client.h"
#include "procgen_client/step_stream.h"
#include "server/rpc/server.h"
#include "server/shared_memory/shared_layout.h"
#include "tests/benchmark/action_tape.h"
#include "tests/benchmark/time_now.h"

namespace procgen {
namespace {

constexpr char kGame[] = "bigfish";
constexpr char kFolder[] = "/dev/shm";
constexpr int32_t kWorkerCount = 2;
constexpr int kRequestsInFlight = 2;
constexpr int kWarmUpSteps = 50;
// How long each of the two is measured in one round.
constexpr absl::Duration kRound = absl::Milliseconds(50);

// A server in this process, a pool on it, and a learner that keeps kRequestsInFlight requests
// unanswered.
class SharedLearner {
 public:
  static absl::StatusOr<std::unique_ptr<SharedLearner>> Start(int32_t env_count) {
    auto learner = std::unique_ptr<SharedLearner>(new SharedLearner(env_count));
    absl::Status status = learner->Connect(env_count);
    for (int step = 1; step < kRequestsInFlight && status.ok(); ++step) {
      status = learner->Send();
    }
    if (!status.ok()) {
      return status;
    }
    return learner;
  }

  // Sends a step and receives the answer to the one before.
  absl::Status Step() {
    absl::Status status = Send();
    return status.ok() ? stream_->Receive(&batch_) : status;
  }

 private:
  explicit SharedLearner(int32_t env_count) : actions_(env_count) {}

  absl::Status Connect(int32_t env_count) {
    auto folder = SharedFolder::Open(kFolder);
    if (!folder.ok()) {
      return folder.status();
    }
    ServerOptions options;
    options.address = "127.0.0.1:0";
    options.worker_count = kWorkerCount;
    options.shared_folder = *std::move(folder);
    auto server = Server::Start(options);
    if (!server.ok()) {
      return server.status();
    }
    server_ = *std::move(server);
    auto client = procgen_client::Client::Connect(server_->address());
    if (!client.ok()) {
      return client.status();
    }
    client_ = *std::move(client);
    v1::PoolSpec spec;
    spec.add_games(kGame);
    spec.set_env_count(env_count);
    spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
    spec.set_transport(v1::TRANSPORT_SHARED_MEMORY);
    const auto pool = client_->CreatePool(spec);
    if (!pool.ok()) {
      return pool.status();
    }
    auto stream = client_->Attach(pool->name(), {.requests_in_flight_max = kRequestsInFlight});
    if (stream.ok()) {
      stream_ = *std::move(stream);
    }
    return stream.status();
  }

  absl::Status Send() {
    v1::StepPoolRequest request;
    const absl::Span<const int32_t> actions = actions_.Next();
    request.mutable_step()->mutable_actions()->Add(actions.begin(), actions.end());
    return stream_->Send(std::move(request)).status();
  }

  // In the order of making: each is used by the next.
  std::unique_ptr<Server> server_;
  std::unique_ptr<procgen_client::Client> client_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  ActionTape actions_;
  procgen_client::Batch batch_;
};

// The same pool in this process, stepped by as many workers (the calling thread is one of them)
// into memory that is laid out alike.
class LocalPool {
 public:
  static absl::StatusOr<std::unique_ptr<LocalPool>> Start(int32_t env_count) {
    PoolOptions options;
    options.games = {kGame};
    options.env_count = env_count;
    options.environment.distribution_mode = DistributionMode::kEasy;
    auto pool = Pool::Create(options, std::make_shared<Crew>(kWorkerCount - 1));
    if (!pool.ok()) {
      return pool.status();
    }
    return std::unique_ptr<LocalPool>(new LocalPool(*std::move(pool)));
  }

  absl::Status Step() {
    return pool_->Step({.first = 0, .count = pool_->env_count(), .actions = actions_.Next()},
                       batch_);
  }

 private:
  explicit LocalPool(std::unique_ptr<Pool> pool)
      : pool_(std::move(pool)), actions_(pool_->env_count()) {
    const SharedLayout layout(pool_->env_count(), static_cast<int64_t>(pool_->observation_bytes()));
    memory_.resize(static_cast<size_t>(layout.batch_bytes()));
    batch_ = layout.Rows(memory_.data(), 0, pool_->env_count());
    batch_.final_observations = {};
  }

  std::unique_ptr<Pool> pool_;
  ActionTape actions_;
  std::vector<uint8_t> memory_;
  Batch batch_;
};

// Works for a round; `best` becomes the mean of one piece of work, if it was more before: what else
// runs on the machine makes a round slower, never faster.
absl::Status MeasureRound(absl::FunctionRef<absl::Status()> work, absl::Duration* best) {
  const absl::Duration start = TimeNow(TimeKind::kWall);
  absl::Duration passed;
  int count = 0;
  while (passed < kRound) {
    if (absl::Status status = work(); !status.ok()) {
      return status;
    }
    ++count;
    passed = TimeNow(TimeKind::kWall) - start;
  }
  *best = std::min(*best, passed / count);
  return absl::OkStatus();
}

void RunSharedMemory(int32_t env_count, benchmark::State& state) {
  const auto learner = SharedLearner::Start(env_count);
  const auto local = LocalPool::Start(env_count);
  absl::Status status = learner.ok() ? local.status() : learner.status();
  for (int step = 0; step < kWarmUpSteps && status.ok(); ++step) {
    status = (*learner)->Step();
    status.Update((*local)->Step());
  }
  absl::Duration shared_step = absl::InfiniteDuration();
  absl::Duration local_step = absl::InfiniteDuration();
  for ([[maybe_unused]] const auto iteration : state) {
    if (status.ok()) {
      status = MeasureRound([&] { return (*learner)->Step(); }, &shared_step);
    }
    if (status.ok()) {
      status = MeasureRound([&] { return (*local)->Step(); }, &local_step);
    }
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    state.SetIterationTime(absl::ToDoubleSeconds(2 * kRound));
  }
  if (status.ok()) {
    // A ratio of rates is the inverse ratio of times.
    state.counters["inprocess_ratio"] = absl::FDivDuration(local_step, shared_step);
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(shared_step);
  }
}

}  // namespace

void RegisterSharedMemoryStreams() {
  for (const int32_t env_count : {16, 64, 256}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("stream/shm/environments:", env_count).c_str(),
        [env_count](benchmark::State& state) { RunSharedMemory(env_count, state); })
        ->UseManualTime();
  }
}

}  // namespace procgen
