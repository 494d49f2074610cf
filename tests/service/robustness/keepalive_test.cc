// Keepalive pings detect peers that vanish silently.

#include <memory>
#include <utility>

#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "procgen_client/remote_pool.h"
#include "server/rpc/server.h"
#include "tests/service/robustness/fault_proxy.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr absl::Duration kSoon = absl::Milliseconds(200);

class KeepaliveTest : public testing::Test {
 protected:
  KeepaliveTest() {
    ServerOptions options;
    options.address = "127.0.0.1:0";
    options.keepalive_time = kSoon;
    options.keepalive_timeout = kSoon;
    server_ = *Server::Start(options);
    client_ = *procgen_client::Client::Connect(server_->address());
    proxy_ = std::make_unique<FaultProxy>(FaultProxy::Options{.target = server_->address()});
  }

  std::unique_ptr<Server> server_;
  std::unique_ptr<procgen_client::Client> client_;
  std::unique_ptr<FaultProxy> proxy_;
};

TEST_F(KeepaliveTest, ServerFreesThePoolOfAVanishedLearner) {
  PoolStream run(ChannelTo(proxy_->address()));
  ASSERT_THAT(run.Start(MazeSpec(1)), IsOk());
  ASSERT_THAT(client_->GetPool(run.name()), IsOk());
  proxy_->Freeze();
  while (client_->GetPool(run.name()).ok()) {
  }
  proxy_ = nullptr;
}

TEST_F(KeepaliveTest, ClientDetectsAVanishedServer) {
  auto client = procgen_client::Client::Connect(
      proxy_->address(), {.keepalive_time = kSoon, .keepalive_timeout = kSoon});
  ASSERT_THAT(client, IsOk());
  PoolOptions maze;
  maze.games = {"maze"};
  maze.env_count = 1;
  procgen_client::RemotePoolOptions options;
  options.recovery.reconnect_timeout = absl::ZeroDuration();
  const auto pool = procgen_client::RemotePool::Create(*std::move(client), maze, options);
  ASSERT_THAT(pool, IsOk());
  proxy_->Freeze();
  const int32_t action = 4;
  EXPECT_THAT((*pool)->Step({.count = 1, .actions = {&action, 1}}, {}, {}),
              StatusIs(absl::StatusCode::kUnavailable, testing::_));
}

TEST_F(KeepaliveTest, IdleLearnerStaysConnected) {
  // Client and server send frequent pings; gRPC's default would close such a connection.
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 100);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  PoolStream run(
      grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(), arguments));
  ASSERT_THAT(run.Start(MazeSpec(1)), IsOk());
  v1::Batch batch;
  ASSERT_THAT(run.Step({4}, &batch), IsOk());
  absl::SleepFor(absl::Seconds(1));  // an idle learner
  EXPECT_THAT(run.Step({4}, &batch), IsOk());
}

}  // namespace
}  // namespace procgen
