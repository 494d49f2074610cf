#include "tests/benchmark/learners/remote_learner.h"

#include <chrono>
#include <utility>

#include "absl/types/span.h"
#include "procgen_client/servers.h"

namespace procgen {
namespace {

constexpr int kRemoteWarmUpSteps = 50;

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> StartStreamServer() {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.worker_count = kStreamWorkerCount;
  return Server::Start(options);
}

absl::StatusOr<std::unique_ptr<RemoteLearner>> RemoteLearner::Start(const std::string& address,
                                                                    const RemoteCase& remote_case) {
  const auto servers = procgen_client::Servers::Connect(address);
  if (!servers.ok()) {
    return servers.status();
  }
  PoolOptions options;
  options.games = {remote_case.game};
  options.env_count = remote_case.env_count;
  options.environment.distribution_mode = DistributionMode::kEasy;
  auto pool = procgen_client::CreatePool(*servers, options);
  if (!pool.ok()) {
    return pool.status();
  }
  std::unique_ptr<RemoteLearner> learner(new RemoteLearner(remote_case));
  learner->pool_ = *std::move(pool);
  for (int step = 0; step < kRemoteWarmUpSteps; ++step) {
    if (absl::Status status = learner->Step(); !status.ok()) {
      return status;
    }
  }
  return learner;
}

RemoteLearner::RemoteLearner(const RemoteCase& remote_case)
    : case_(remote_case),
      actions_(remote_case.env_count),
      answers_(static_cast<size_t>(remote_case.requests_in_flight)) {
  for (Answer& answer : answers_) {
    answer.observations.resize(static_cast<size_t>(case_.env_count) * kObservationBytes);
  }
}

absl::Status RemoteLearner::SendStep() {
  Answer& answer = answers_[step_++ % answers_.size()];
  Batch batch;
  batch.observations = absl::MakeSpan(answer.observations);
  return pool_->Send({.count = case_.env_count, .actions = actions_.Next()}, {},
                     answer.numbers.ReplaceEmptyArrays(batch, case_.env_count));
}

absl::Status RemoteLearner::Receive() { return pool_->Receive(std::chrono::duration<double>(-1)); }

absl::Status RemoteLearner::Step() {
  absl::Status status = SendStep();
  return status.ok() ? Receive() : status;
}

absl::Status RemoteLearner::SendAhead() {
  absl::Status status;
  for (int ahead = 1; ahead < case_.requests_in_flight && status.ok(); ++ahead) {
    status = SendStep();
  }
  return status;
}

absl::Status RemoteLearner::Exchange() { return Step(); }

absl::Status RemoteLearner::ReceiveRest() {
  absl::Status status;
  for (int ahead = 1; ahead < case_.requests_in_flight && status.ok(); ++ahead) {
    status = Receive();
  }
  return status;
}

StreamShape RemoteLearner::Shape() const {
  const auto rows = static_cast<size_t>(case_.env_count);
  const size_t row_bytes =
      kObservationBytes + sizeof(float) * 2 + sizeof(int32_t) * 3 + sizeof(bool) * 4;
  return {.request_bytes = rows,  // one byte per action
          .response_bytes = rows * row_bytes,
          .requests_in_flight = case_.requests_in_flight};
}

}  // namespace procgen
