#include "tests/service/service_fixture.h"

#include <utility>

#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"

namespace procgen {

v1::PoolSpec MazeSpec(int32_t env_count) {
  v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(env_count);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(7);
  return spec;
}

v1::StepPoolRequest StepRequest(const std::vector<int32_t>& actions) {
  v1::StepPoolRequest request;
  request.mutable_step()->mutable_actions()->Add(actions.begin(), actions.end());
  return request;
}

v1::StepPoolRequest SliceStepRequest(int32_t first, int32_t count, int32_t action) {
  v1::StepPoolRequest request =
      StepRequest(std::vector<int32_t>(static_cast<size_t>(count), action));
  request.mutable_step()->mutable_slice()->set_first_env(first);
  request.mutable_step()->mutable_slice()->set_env_count(count);
  return request;
}

v1::ClonePair Pair(int32_t source_environment, int32_t target_environment) {
  v1::ClonePair pair;
  pair.set_source_environment(source_environment);
  pair.set_target_environment(target_environment);
  return pair;
}

Limits ServiceTest::TestLimits() {
  Limits limits;
  limits.pool_count_max = 4;
  limits.pool_env_count_max = 500;
  limits.env_count_max = 600;
  limits.request_bytes_max = 65536;
  limits.response_bytes_max = 16 << 20;
  limits.requests_in_flight_max = 8;
  return limits;
}

std::unique_ptr<Server> ServiceTest::StartServer(int32_t worker_count) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.worker_count = worker_count;
  options.limits = TestLimits();
  options.clone_source_allowlist = *CloneSourceAllowlist::Parse("local");
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  EXPECT_THAT(server, IsOk());
  return server.ok() ? *std::move(server) : nullptr;
}

void ServiceTest::SetUp() {
  server_ = StartServer(/*worker_count=*/2);
  ASSERT_NE(server_, nullptr);
  channel_ = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  client_ = Connect();
  ASSERT_NE(client_, nullptr);
  control_learner_ = CreateAndAttach(MazeSpec(2));
  ASSERT_NE(control_learner_, nullptr);
}

void ServiceTest::TearDown() {
  if (server_is_alive_ && control_learner_ != nullptr) {
    procgen_client::Batch batch;
    EXPECT_THAT(control_learner_->Step({4, 4}, &batch), IsOk());
    EXPECT_THAT(client_->GetCatalog(), IsOk());
    EXPECT_THAT(control_learner_->Close(), IsOk());
  }
}

std::unique_ptr<procgen_client::Client> ServiceTest::Connect(int32_t response_bytes_max) {
  procgen_client::ConnectOptions options;
  options.response_bytes_max = response_bytes_max;
  absl::StatusOr<std::unique_ptr<procgen_client::Client>> client =
      procgen_client::Client::Connect(server_->address(), options);
  EXPECT_THAT(client, IsOk());
  return client.ok() ? *std::move(client) : nullptr;
}

std::string ServiceTest::CreatePool(const v1::PoolSpec& spec) {
  const absl::StatusOr<v1::Pool> pool = client_->CreatePool(spec);
  EXPECT_THAT(pool, IsOk());
  return pool.ok() ? pool->name() : "";
}

std::unique_ptr<procgen_client::StepStream> ServiceTest::CreateAndAttach(
    const v1::PoolSpec& spec, const procgen_client::StreamOptions& options) {
  absl::StatusOr<std::unique_ptr<procgen_client::StepStream>> stream =
      client_->Attach(CreatePool(spec), options);
  EXPECT_THAT(stream, IsOk());
  return stream.ok() ? *std::move(stream) : nullptr;
}

absl::Status ServiceTest::CallStatus(procgen_client::StepStream* stream,
                                     v1::StepPoolRequest request) {
  procgen_client::Batch batch;
  return stream->Call(std::move(request), &batch);
}

}  // namespace procgen
