#include "server/fleet/pool/request_progress.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr Part kLeft = {0, 4};
constexpr Part kRight = {4, 4};

// A request of eight environments in two shards.
class RequestProgressTest : public testing::Test {
 protected:
  void SetUp() override { progress_.Begin({0, 8}); }

  void Start() { progress_.Start({kLeft, kRight}); }
  bool AddPart(Part part) {
    return progress_.AddPart(part, {}, [](auto) {}).has_value();
  }
  bool Finish(Part shard) { return progress_.OnShardDone(shard, absl::OkStatus()).has_value(); }

  RequestProgress progress_;
};

TEST_F(RequestProgressTest, PartWaitsForItsShards) {
  Start();
  EXPECT_FALSE(AddPart({3, 2}));
  EXPECT_FALSE(Finish(kLeft));
  EXPECT_TRUE(Finish(kRight));
}

TEST_F(RequestProgressTest, PartIsAnsweredWhileOtherShardsRun) {
  Start();
  EXPECT_FALSE(AddPart({0, 2}));
  EXPECT_TRUE(Finish(kLeft));
  EXPECT_TRUE(AddPart({2, 2})) << "its shard is done already";
}

TEST_F(RequestProgressTest, LastPartWaitsForAllShards) {
  Start();
  EXPECT_FALSE(AddPart({6, 2}));
  EXPECT_FALSE(Finish(kRight));
  EXPECT_TRUE(Finish(kLeft));
}

TEST_F(RequestProgressTest, NoPartIsAnsweredBeforeTheShardsStart) {
  EXPECT_FALSE(AddPart({0, 2}));
  Start();
  EXPECT_TRUE(Finish(kLeft));
}

TEST_F(RequestProgressTest, ErrorIsReturnedWhenAllShardsAreDone) {
  Start();
  EXPECT_FALSE(AddPart({0, 2}));
  EXPECT_FALSE(progress_.OnShardDone(kLeft, absl::DataLossError("first")).has_value());
  const auto answer = progress_.OnShardDone(kRight, absl::InternalError("second"));
  ASSERT_TRUE(answer.has_value());
  EXPECT_THAT(answer->status, StatusIs(absl::StatusCode::kDataLoss, "first"));
}

TEST_F(RequestProgressTest, RequestWithoutShardsEndsWithItsStatus) {
  progress_.Start({}, absl::ResourceExhaustedError("full"));
  const auto answer = progress_.AddPart({0, 2}, {}, [](auto) {});
  ASSERT_TRUE(answer.has_value());
  EXPECT_THAT(answer->status, StatusIs(absl::StatusCode::kResourceExhausted, "full"));
}

}  // namespace
}  // namespace procgen
