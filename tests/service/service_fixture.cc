#include "tests/service/service_fixture.h"

#include <utility>

namespace procgen {

v1::PoolSpec MazeSpec(int32_t env_count) {
  v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(env_count);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(7);
  return spec;
}

Limits ServiceTest::TestLimits() {
  Limits limits;
  limits.env_count_max = 600;
  limits.owner_env_count_max = 500;
  limits.request_bytes_max = 65536;
  limits.response_bytes_max = 16 << 20;
  return limits;
}

std::unique_ptr<Server> ServiceTest::StartServer(int32_t worker_count, const Limits& limits) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.worker_count = worker_count;
  options.limits = limits;
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  EXPECT_THAT(server, IsOk());
  return server.ok() ? *std::move(server) : nullptr;
}

void ServiceTest::SetUp() {
  server_ = StartServer(/*worker_count=*/2);
  ASSERT_NE(server_, nullptr);
  channel_ = ChannelTo(server_->address());
  auto client = procgen_client::Client::Connect(server_->address());
  ASSERT_THAT(client, IsOk());
  client_ = *std::move(client);
  control_learner_ = StartPool(MazeSpec(2));
  ASSERT_NE(control_learner_, nullptr);
}

void ServiceTest::TearDown() {
  if (server_is_alive_ && control_learner_ != nullptr) {
    v1::Batch batch;
    EXPECT_THAT(control_learner_->Step({4, 4}, &batch), IsOk());
    EXPECT_THAT(client_->GetCatalog(), IsOk());
    EXPECT_THAT(control_learner_->Close(), IsOk());
  }
}

std::unique_ptr<PoolStream> ServiceTest::StartPool(const v1::PoolSpec& spec,
                                                   const std::string& pool_id) {
  auto run = std::make_unique<PoolStream>(channel_);
  const absl::StatusOr<v1::Started> started = run->Start(spec, {}, pool_id);
  EXPECT_THAT(started, IsOk());
  return started.ok() ? std::move(run) : nullptr;
}

absl::Status ServiceTest::StartError(const v1::PoolSpec& spec, const std::string& pool_id) {
  PoolStream run(channel_);
  if (absl::Status status = run.Start(spec, {}, pool_id).status(); !status.ok()) {
    return status;
  }
  return run.Close();
}

}  // namespace procgen
