#include "server/rpc/server.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "gtest/gtest.h"
#include "tests/service/pool_stream.h"
#include "tests/service/raw_call.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(ServerTest, RejectedStreamsLeakNothing) {
  constexpr int kStreamCount = 1500;
  constexpr int64_t kGrowthBytes = 1 << 20;  // 700 per stream; an open one has about 20,000
  ServerOptions options;
  options.address = "127.0.0.1:0";
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const std::shared_ptr<grpc::Channel> channel = ChannelTo((*server)->address());
  v1::PoolSpec spec;
  spec.add_games("none");
  spec.set_env_count(1);
  // Rejected at the first request, while more arrive.
  const std::vector<std::string> requests(4, StartRequest(spec).SerializeAsString());
  int64_t before = 0;
  for (int i = 0; i < 2 * kStreamCount; ++i) {
    before = i == kStreamCount ? AllocatedBytes() : before;
    const RawResult rejected = CallRaw(channel, kRunPoolPath, requests);
    ASSERT_EQ(rejected.status.code(), absl::StatusCode::kNotFound) << rejected.status;
  }
  // The server's threads free a stream some time after its end, later on a busy machine.
  const absl::Time deadline = absl::Now() + absl::Seconds(10);
  while (AllocatedBytes() >= before + kGrowthBytes && absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(10));
  }
  EXPECT_LT(AllocatedBytes(), before + kGrowthBytes);
}

}  // namespace
}  // namespace procgen
