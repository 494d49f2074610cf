// procgen-benchmark-stream: how many environment steps a second a learner gets over gRPC on
// loopback, beside a bare gRPC stream that sends messages of the same size. README.md beside this
// file says what the figures mean.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "benchmark/benchmark.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/client.h"
#include "procgen_client/step_stream.h"
#include "server/rpc/server.h"
#include "server/session/event_log.h"
#include "tests/benchmark/action_tape.h"
#include "tests/benchmark/bare_stream.h"
#include "tests/benchmark/benchmark_run.h"
#include "tests/benchmark/round_clock.h"
#include "tests/benchmark/shared_memory_benchmark.h"

namespace procgen {
namespace {

// The game whose steps cost least, so that the stream shows.
constexpr char kGame[] = "bigfish";
constexpr int32_t kWorkerCount = 2;
constexpr int kRequestsInFlight = 2;
constexpr int kWarmUpSteps = 50;
constexpr double kMinTimeSeconds = 0.5;

// A server in this process, a pool on it, and a learner that keeps kRequestsInFlight requests
// unanswered.
class RemoteLearner {
 public:
  static absl::StatusOr<std::unique_ptr<RemoteLearner>> Start(int32_t env_count) {
    auto learner = std::unique_ptr<RemoteLearner>(new RemoteLearner(env_count));
    if (absl::Status status = learner->Connect(env_count); !status.ok()) {
      return status;
    }
    for (int step = 0; step < kWarmUpSteps; ++step) {
      if (absl::Status status = learner->Exchange(); !status.ok()) {
        return status;
      }
    }
    return learner;
  }

  // Sends a step and receives the answer to the one before.
  absl::Status Exchange() {
    if (absl::Status status = Send(); !status.ok()) {
      return status;
    }
    return stream_->Receive(&batch_);
  }

  // What goes over the wire. The arrays of a batch are on the wire as they are in memory; the tags
  // around them do not count.
  StreamShape Shape() const {
    const size_t row_bytes = sizeof(float) * 2 + sizeof(int32_t) * 3 + sizeof(bool) * 4;
    return {.request_bytes = request_bytes_,
            .response_bytes = batch_.observations().size() + batch_.rewards().size() * row_bytes,
            .requests_in_flight = kRequestsInFlight};
  }

 private:
  explicit RemoteLearner(int32_t env_count) : actions_(env_count) {}

  absl::Status Connect(int32_t env_count) {
    ServerOptions options;
    options.address = "127.0.0.1:0";
    options.worker_count = kWorkerCount;
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
    const auto pool = client_->CreatePool(spec);
    if (!pool.ok()) {
      return pool.status();
    }
    auto stream = client_->Attach(pool->name(), {.requests_in_flight_max = kRequestsInFlight});
    if (!stream.ok()) {
      return stream.status();
    }
    stream_ = *std::move(stream);
    absl::Status status;
    for (int ahead = 1; ahead < kRequestsInFlight && status.ok(); ++ahead) {
      status = Send();
    }
    return status;
  }

  absl::Status Send() {
    v1::StepPoolRequest request;
    const absl::Span<const int32_t> actions = actions_.Next();
    request.mutable_step()->mutable_actions()->Add(actions.begin(), actions.end());
    request_bytes_ = request.ByteSizeLong();
    return stream_->Send(std::move(request)).status();
  }

  // In the order of making: each is used by the next.
  std::unique_ptr<Server> server_;
  std::unique_ptr<procgen_client::Client> client_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  ActionTape actions_;
  procgen_client::Batch batch_;
  size_t request_bytes_ = 0;
};

void RunStream(int32_t env_count, benchmark::State& state) {
  const auto learner = RemoteLearner::Start(env_count);
  absl::Status status = learner.status();
  absl::StatusOr<std::unique_ptr<BareStream>> bare;
  if (status.ok()) {
    bare = BareStream::Start((*learner)->Shape());
    status = bare.status();
  }
  absl::Duration bare_exchange = absl::InfiniteDuration();
  RoundClock clock(TimeKind::kWall);
  clock.Start();
  for ([[maybe_unused]] const auto iteration : state) {
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      break;
    }
    status = (*learner)->Exchange();
    if (clock.Lap()) {
      state.PauseTiming();
      bare_exchange = std::min(bare_exchange, (*bare)->MeasureExchange());
      state.ResumeTiming();
      clock.Start();
    }
  }
  if (status.ok()) {
    bare_exchange = std::min(bare_exchange, (*bare)->MeasureExchange());
    // A ratio of rates is the inverse ratio of times.
    state.counters["wire_ratio"] = absl::FDivDuration(bare_exchange, clock.Best());
    state.counters["items_per_second"] = env_count / absl::ToDoubleSeconds(clock.Best());
  }
}

void RegisterStreams() {
  for (const int32_t env_count : {1, 16, 64, 256}) {
    benchmark::RegisterBenchmark(
        absl::StrCat("stream/tcp/environments:", env_count).c_str(),
        [env_count](benchmark::State& state) { RunStream(env_count, state); });
  }
  RegisterSharedMemoryStreams();
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  procgen::SetLogLevel(procgen::LogLevel::kError);
  return procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterStreams);
}
