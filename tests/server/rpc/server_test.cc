#include "server/rpc/server.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "procgen/v1/step.pb.h"
#include "tests/service/holdings.h"
#include "tests/service/raw_call.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(ServerTest, StreamsWithinTheProcessLeaveNothing) {
  constexpr int kStreamCount = 1500;
  constexpr int64_t kGrowthBytes = 1 << 20;  // 700 a stream, which has some 20,000 while it is open
  ServerOptions options;
  options.address = "127.0.0.1:0";
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const std::shared_ptr<grpc::Channel> channel = (*server)->MakeChannel();
  v1::StepPoolRequest attach;
  attach.mutable_attach()->set_pool("pools/none");
  // Refused with the first, while the others come.
  const std::vector<std::string> requests(4, attach.SerializeAsString());
  int64_t before = 0;
  for (int i = 0; i < 2 * kStreamCount; ++i) {
    before = i == kStreamCount ? AllocatedBytes() : before;
    const RawResult refused = CallRaw(channel, "/procgen.v1.StepService/StepPool", requests);
    ASSERT_EQ(refused.status.code(), absl::StatusCode::kNotFound) << refused.status;
  }
  EXPECT_LT(AllocatedBytes(), before + kGrowthBytes);
}

}  // namespace
}  // namespace procgen
