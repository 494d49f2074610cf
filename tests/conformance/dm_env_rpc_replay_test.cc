// The golden recordings, replayed through dm_env_rpc.

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "server/rpc/server.h"
#include "tests/conformance/dm_env_rpc_player.h"
#include "tests/conformance/recordings.h"
#include "tests/status_matchers.h"
#include "tools/conformance/replay.h"

namespace procgen {
namespace {

class DmEnvRpcReplayTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    ServerOptions options;
    options.address = "127.0.0.1:0";
    absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
    ASSERT_THAT(server, IsOk());
    server_ = *std::move(server);
    absl::StatusOr<Trace> trace = ReadTrace(GetParam());
    ASSERT_THAT(trace, IsOk());
    trace_ = *std::move(trace);
    with_pictures_ = trace_.HasComparablePictures(false);
  }

  std::unique_ptr<Server> server_;
  Trace trace_;
  bool with_pictures_ = false;
};

TEST_P(DmEnvRpcReplayTest, BatchedWorldMatchesTheRecordings) {
  const auto player = MakeBatchedWorldPlayer(trace_, server_->address(), with_pictures_);
  ASSERT_THAT(player, IsOk());
  EXPECT_EQ(FirstDifference(trace_, **player, with_pictures_), "");
}

TEST_P(DmEnvRpcReplayTest, SingleEnvironmentsMatchTheRecordings) {
  if (std::find(trace_.actions.begin(), trace_.actions.end(), kEndEpisodeAction) !=
      trace_.actions.end()) {
    GTEST_SKIP() << "a single environment has no action that ends an episode";
  }
  const auto player = MakeSingleWorldsPlayer(trace_, server_->address(), with_pictures_);
  ASSERT_THAT(player, IsOk());
  EXPECT_EQ(FirstDifference(trace_, **player, with_pictures_), "");
}

std::string NameOf(const testing::TestParamInfo<std::string>& info) {
  std::string name = std::filesystem::path(info.param).stem().string();
  std::replace_if(
      name.begin(), name.end(), [](char letter) { return letter == '.' || letter == '-'; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Golden, DmEnvRpcReplayTest,
                         testing::ValuesIn(TracesIn(PROCGEN_SOURCE_DIR
                                                    "/tests/conformance/golden")),
                         NameOf);

}  // namespace
}  // namespace procgen
