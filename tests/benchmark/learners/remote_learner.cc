#include "tests/benchmark/learners/remote_learner.h"

#include <utility>

#include "absl/types/span.h"
#include "procgen/v1/pools.pb.h"

namespace procgen {
namespace {

constexpr int kRemoteWarmUpSteps = 50;
constexpr char kSharedFolder[] = "/dev/shm";

}  // namespace

absl::StatusOr<std::unique_ptr<Server>> StartStreamServer() {
  auto folder = SharedMemoryDir::Open(kSharedFolder);
  if (!folder.ok()) {
    return folder.status();
  }
  ServerOptions options;
  options.shared_memory_dir = *std::move(folder);
  options.address = "127.0.0.1:0";
  options.worker_count = kStreamWorkerCount;
  return Server::Start(options);
}

absl::StatusOr<std::unique_ptr<RemoteLearner>> RemoteLearner::Start(const std::string& address,
                                                                    const RemoteCase& remote_case) {
  auto client = procgen_client::Client::Connect(address);
  if (!client.ok()) {
    return client.status();
  }
  auto learner = std::unique_ptr<RemoteLearner>(new RemoteLearner(*std::move(client), remote_case));
  absl::Status status = learner->MakePool();
  for (int step = 0; step < kRemoteWarmUpSteps && status.ok(); ++step) {
    status = learner->Step();
  }
  if (!status.ok()) {
    return status;
  }
  return learner;
}

RemoteLearner::RemoteLearner(std::unique_ptr<procgen_client::Client> client,
                             const RemoteCase& remote_case)
    : case_(remote_case), client_(std::move(client)), actions_(remote_case.env_count) {}

RemoteLearner::~RemoteLearner() {
  stream_.reset();
  client_->DeletePool(pool_).IgnoreError();
}

absl::Status RemoteLearner::MakePool() {
  v1::PoolSpec spec;
  spec.add_games(case_.game);
  spec.set_env_count(case_.env_count);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(0);  // same levels as LocalLearner
  if (case_.shares_memory) {
    spec.set_transport(v1::TRANSPORT_SHARED_MEMORY);
  }
  if (case_.is_compressed) {
    spec.set_encoding(v1::ENCODING_DELTA_ZSTD);
  }
  const auto pool = client_->CreatePool(spec);
  if (!pool.ok()) {
    return pool.status();
  }
  pool_ = pool->name();
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = case_.requests_in_flight;
  options.chunk_count = case_.chunk_count;
  auto stream = client_->Attach(pool_, options);
  if (!stream.ok()) {
    return stream.status();
  }
  stream_ = *std::move(stream);
  return absl::OkStatus();
}

absl::Status RemoteLearner::Step() { return stream_->Step(actions_.Next(), &batch_); }

absl::Status RemoteLearner::SendAhead() {
  absl::Status status;
  for (int ahead = 1; ahead < case_.requests_in_flight && status.ok(); ++ahead) {
    status = stream_->SendStep(actions_.Next()).status();
  }
  return status;
}

absl::Status RemoteLearner::Exchange() {
  batch_.Release();
  absl::Status status = stream_->SendStep(actions_.Next()).status();
  return status.ok() ? stream_->Receive(&batch_) : status;
}

absl::Status RemoteLearner::ReceiveRest() {
  absl::Status status;
  for (int ahead = 1; ahead < case_.requests_in_flight && status.ok(); ++ahead) {
    status = stream_->Receive(&batch_);
  }
  return status;
}

StreamShape RemoteLearner::Shape() const {
  const size_t row_bytes = sizeof(float) * 2 + sizeof(int32_t) * 3 + sizeof(bool) * 4;
  return {.request_bytes = static_cast<size_t>(case_.env_count),  // one byte per action
          .response_bytes = batch_.observations().size() + batch_.rewards().size() * row_bytes,
          .requests_in_flight = case_.requests_in_flight};
}

}  // namespace procgen
