// Keepalive pings detect peers that vanish silently.

#include <memory>

#include "gtest/gtest.h"
#include "procgen_client/client.h"
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
    pool_ = client_->CreatePool(MazeSpec(1))->name();
  }

  std::unique_ptr<Server> server_;
  std::unique_ptr<procgen_client::Client> client_;
  std::unique_ptr<FaultProxy> proxy_;
  std::string pool_;
};

TEST_F(KeepaliveTest, ServerDetachesAVanishedLearner) {
  const auto learner = *procgen_client::Client::Connect(proxy_->address());
  const auto stream = learner->Attach(pool_);
  ASSERT_THAT(stream, IsOk());
  ASSERT_TRUE(client_->GetPool(pool_)->attached());
  proxy_->Freeze();
  while (client_->GetPool(pool_)->attached()) {
  }
  proxy_ = nullptr;
}

TEST_F(KeepaliveTest, ClientDetectsAVanishedServer) {
  const auto learner = *procgen_client::Client::Connect(
      proxy_->address(), {.keepalive_time = kSoon, .keepalive_timeout = kSoon});
  const auto stream = learner->Attach(pool_, {.reconnect_timeout = absl::ZeroDuration()});
  ASSERT_THAT(stream, IsOk());
  proxy_->Freeze();
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Step({4}, &batch), StatusIs(absl::StatusCode::kUnavailable, testing::_));
}

TEST_F(KeepaliveTest, IdleLearnerStaysConnected) {
  // Client and server send frequent pings; gRPC's default would close such a connection.
  const auto learner = *procgen_client::Client::Connect(
      server_->address(),
      {.keepalive_time = absl::Milliseconds(100), .keepalive_timeout = absl::Seconds(5)});
  const auto stream = learner->Attach(pool_, {.reconnect_timeout = absl::ZeroDuration()});
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
  absl::SleepFor(absl::Seconds(1));  // an idle learner
  EXPECT_THAT((*stream)->Step({4}, &batch), IsOk());
}

}  // namespace
}  // namespace procgen
