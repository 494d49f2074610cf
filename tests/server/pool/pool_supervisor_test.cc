#include "server/pool/pool_supervisor.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

using CreateResult = absl::StatusOr<std::shared_ptr<PoolSession>>;

Limits SmallLimits() {
  Limits limits;
  limits.env_count_max = 10;
  limits.owner_env_count_max = 8;
  limits.owner_bytes_max = 4 << 20;
  return limits;
}

PoolOptions MazeOptions(int32_t env_count) {
  PoolOptions options;
  options.games = {"maze"};
  options.env_count = env_count;
  return options;
}

class PoolSupervisorTest : public testing::Test {
 protected:
  CreateResult Create(
      absl::string_view id, const PoolOptions& options, absl::string_view owner = "",
      PoolSession::EndStream end_stream = [](const absl::Status&) {}) {
    CreateResult result = absl::UnknownError("not yet");
    absl::Notification done;
    supervisor_.Create(owner, id, options, SessionOptions(), std::move(end_stream),
                       [&](CreateResult created) {
                         result = std::move(created);
                         done.Notify();
                       });
    done.WaitForNotification();
    return result;
  }

  Metrics metrics_{"test"};
  PoolSupervisor supervisor_{SmallLimits(), 1, &metrics_};
};

TEST_F(PoolSupervisorTest, PoolsOfOtherOwnersAreNotFound) {
  ASSERT_THAT(Create("a", MazeOptions(1), "alice"), IsOk());
  EXPECT_THAT(supervisor_.Find("alice", "pools/a"), IsOk());
  for (const char* other : {"bob", "", "alic", "alice2"}) {
    EXPECT_THAT(supervisor_.Find(other, "pools/a"),
                StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/a"));
    EXPECT_TRUE(supervisor_.List(other, 0, 9).empty());
  }
  EXPECT_EQ(supervisor_.List("alice", 0, 9).size(), 1U);
}

TEST_F(PoolSupervisorTest, OwnersMayUseTheSamePoolName) {
  const CreateResult of_alice = Create("a", MazeOptions(1), "alice");
  const CreateResult of_bob = Create("a", MazeOptions(2), "bob");
  ASSERT_THAT(of_alice, IsOk());
  ASSERT_THAT(of_bob, IsOk());
  EXPECT_EQ(*supervisor_.Find("alice", "pools/a"), *of_alice);
  EXPECT_EQ(*supervisor_.Find("bob", "pools/a"), *of_bob);
  supervisor_.Free(of_alice->get());
  EXPECT_THAT(supervisor_.Find("alice", "pools/a"),
              StatusIs(absl::StatusCode::kNotFound, testing::_));
  EXPECT_EQ(*supervisor_.Find("bob", "pools/a"), *of_bob);
}

TEST_F(PoolSupervisorTest, MalformedIdsAreRejected) {
  for (const std::string& id :
       {std::string("7"), std::string("Maze"), std::string("a/b"), std::string("a-"),
        std::string("-a"), std::string(64, 'a'), std::string("a\0b", 3)}) {
    EXPECT_THAT(Create(id, MazeOptions(1)),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: 1 to 63 of a-z")));
  }
}

TEST_F(PoolSupervisorTest, BytesOfAnOwnersPoolsAreLimitedUntilOneIsFreed) {
  PoolOptions options = MazeOptions(1);
  options.observation_format.frame.size_px = 512;
  const CreateResult pool = Create("", options);
  ASSERT_THAT(pool, IsOk());
  EXPECT_THAT(Create("", options),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "every caller together has 3211264 bytes of pools and level samplers and "
                       "asks for 3211264 more, limit owner_bytes_max is 4194304"));
  supervisor_.Free(pool->get());
  EXPECT_THAT(Create("", options), IsOk());
}

TEST_F(PoolSupervisorTest, PoolRejectedByTheEngineLeavesNothing) {
  PoolOptions options = MazeOptions(8);
  options.games = {"chess"};
  EXPECT_THAT(Create("a", options), StatusIs(absl::StatusCode::kNotFound, HasSubstr("chess")));
  EXPECT_EQ(supervisor_.load().env_count, 0);
  EXPECT_THAT(Create("a", MazeOptions(8)), IsOk());
}

TEST_F(PoolSupervisorTest, ReferenceToAFreedPoolReturnsAnError) {
  const CreateResult pool = Create("a", MazeOptions(4));
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ(supervisor_.load().pool_count, 1);
  EXPECT_EQ(supervisor_.load().env_count, 4);
  supervisor_.Free(pool->get());
  EXPECT_EQ(supervisor_.load().pool_count, 0);
  EXPECT_EQ(supervisor_.load().env_count, 0);
  absl::Status turn;
  (*pool)->TakeTurn([&](absl::Status status) { turn = std::move(status); });
  EXPECT_THAT(turn, StatusIs(absl::StatusCode::kAborted, "pool pools/a ended with its stream"));
  const CreateResult next = Create("a", MazeOptions(1));
  ASSERT_THAT(next, IsOk());
  supervisor_.Free(pool->get());
  EXPECT_THAT(supervisor_.Find("", "pools/a"), IsOk()) << "a freed pool does not free its namesake";
}

}  // namespace
}  // namespace procgen
