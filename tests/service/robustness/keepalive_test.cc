// Frequent keepalive pings do not end connections. clients/python has tests of peers that vanish.

#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "server/rpc/server.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(KeepaliveTest, IdleLearnerStaysConnected) {
  // gRPC's default would close such a connection.
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.keepalive_time = absl::Milliseconds(200);
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 100);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  PoolStream run(grpc::CreateCustomChannel((*server)->address(), grpc::InsecureChannelCredentials(),
                                           arguments));
  ASSERT_THAT(run.Start(MazeSpec(1)), IsOk());
  v1::Batch batch;
  ASSERT_THAT(run.Step({4}, &batch), IsOk());
  absl::SleepFor(absl::Seconds(1));  // an idle learner
  EXPECT_THAT(run.Step({4}, &batch), IsOk());
}

}  // namespace
}  // namespace procgen
