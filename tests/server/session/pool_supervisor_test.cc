#include "server/session/pool_supervisor.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

using CreateResult = absl::StatusOr<std::shared_ptr<PoolSession>>;

Limits SmallLimits() {
  Limits limits;
  limits.pool_count_max = 2;
  limits.pool_env_count_max = 8;
  limits.env_count_max = 10;
  limits.observation_bytes_max = 1 << 20;
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
  CreateResult Create(absl::string_view id, const PoolOptions& options,
                      absl::string_view owner = "",
                      absl::Duration lease_duration = absl::InfiniteDuration()) {
    CreateResult result = absl::UnknownError("not yet");
    absl::Notification done;
    supervisor_.Create(owner, id, options, {.lease_duration = lease_duration},
                       [&](CreateResult created) {
                         result = std::move(created);
                         done.Notify();
                       });
    done.WaitForNotification();
    return result;
  }

  TestClock clock_;
  Metrics metrics_{"test"};
  PoolSupervisor supervisor_{SmallLimits(), 1, &metrics_, nullptr, [this] { return clock_.Now(); }};
};

TEST_F(PoolSupervisorTest, CreatedPoolIsFoundByItsName) {
  const CreateResult pool = Create("maze-7", MazeOptions(1));
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ((*pool)->name(), "pools/maze-7");
  EXPECT_THAT(supervisor_.Find("", "pools/maze-7"), IsOk());
}

TEST_F(PoolSupervisorTest, PoolWithoutIdGetsANumber) {
  const CreateResult pool = Create("", MazeOptions(1));
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ((*pool)->name(), "pools/1");
}

TEST_F(PoolSupervisorTest, PoolsOfOtherOwnersAreNotFound) {
  ASSERT_THAT(Create("a", MazeOptions(1), "alice"), IsOk());
  EXPECT_THAT(supervisor_.Find("alice", "pools/a"), IsOk());
  for (const char* other : {"bob", "", "alic", "alice2"}) {
    EXPECT_THAT(supervisor_.Find(other, "pools/a"),
                StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/a"));
    EXPECT_THAT(supervisor_.Delete(other, "pools/a"),
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
  ASSERT_THAT(supervisor_.Delete("alice", "pools/a"), IsOk());
  EXPECT_EQ(*supervisor_.Find("bob", "pools/a"), *of_bob);
}

TEST_F(PoolSupervisorTest, DeletionAndFailureFreeTheQuota) {
  Limits limits = SmallLimits();
  limits.owner_pool_count_max = 1;
  PoolSupervisor supervisor(limits, 1, &metrics_);
  const auto create = [&](const PoolOptions& options) {
    absl::Status status;
    absl::Notification done;
    supervisor.Create("alice", "", options, {}, [&](const CreateResult& created) {
      status = created.status();
      done.Notify();
    });
    done.WaitForNotification();
    return status;
  };
  PoolOptions unknown = MazeOptions(1);
  unknown.games = {"chess"};
  EXPECT_THAT(create(unknown), StatusIs(absl::StatusCode::kNotFound, testing::_));
  ASSERT_THAT(create(MazeOptions(1)), IsOk());
  EXPECT_THAT(create(MazeOptions(1)),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("owner alice has 1 pools")));
  ASSERT_THAT(supervisor.Delete("alice", "pools/2"), IsOk());
  EXPECT_THAT(create(MazeOptions(1)), IsOk());
}

TEST_F(PoolSupervisorTest, MalformedIdsAreRejected) {
  for (const std::string& id :
       {std::string("7"), std::string("Maze"), std::string("a/b"), std::string("a-"),
        std::string("-a"), std::string(64, 'a'), std::string("a\0b", 3)}) {
    EXPECT_THAT(Create(id, MazeOptions(1)),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: 1 to 63 of a-z")));
  }
}

TEST_F(PoolSupervisorTest, IdInUseIsRejected) {
  ASSERT_THAT(Create("a", MazeOptions(1)), IsOk());
  EXPECT_THAT(Create("a", MazeOptions(1)),
              StatusIs(absl::StatusCode::kAlreadyExists, HasSubstr("pools/a exists")));
}

TEST_F(PoolSupervisorTest, TooManyPoolsAreRejectedUntilOneIsDeleted) {
  ASSERT_THAT(Create("a", MazeOptions(1)), IsOk());
  ASSERT_THAT(Create("b", MazeOptions(1)), IsOk());
  EXPECT_THAT(
      Create("c", MazeOptions(1)),
      StatusIs(
          absl::StatusCode::kResourceExhausted,
          HasSubstr("there are 2 pools, limit pool_count_max is 2; 2 of 2 own pools without an "
                    "attached learner")));
  ASSERT_THAT(supervisor_.Delete("", "pools/a"), IsOk());
  EXPECT_THAT(Create("c", MazeOptions(1)), IsOk());
}

TEST_F(PoolSupervisorTest, TooLargePoolIsRejected) {
  EXPECT_THAT(Create("", MazeOptions(9)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "spec.env_count is 9, limit pool_env_count_max is 8"));
}

TEST_F(PoolSupervisorTest, PoolWithoutEnvironmentsIsRejected) {
  EXPECT_THAT(Create("", MazeOptions(0)),
              StatusIs(absl::StatusCode::kInvalidArgument, "spec.env_count is 0, allowed: 1 to 8"));
}

TEST_F(PoolSupervisorTest, TooManyEnvironmentsInAllPoolsAreRejected) {
  ASSERT_THAT(Create("", MazeOptions(8)), IsOk());
  EXPECT_THAT(Create("", MazeOptions(3)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("spec.env_count is 3 and there are 8 environments, limit "
                                 "env_count_max is 10; 1 of 1 own pools")));
  EXPECT_THAT(Create("", MazeOptions(2)), IsOk());
}

TEST_F(PoolSupervisorTest, ObservationBytesOfAllPoolsAreLimitedUntilOneIsDeleted) {
  PoolOptions options = MazeOptions(1);
  options.observation_format.frame.size_px = 512;
  ASSERT_THAT(Create("a", options), IsOk());
  EXPECT_THAT(Create("b", options),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("one observation of each environment takes 786432 bytes and those "
                                 "of other pools 786432, limit observation_bytes_max is 1048576")));
  ASSERT_THAT(supervisor_.Delete("", "pools/a"), IsOk());
  options.games = {"chess"};
  EXPECT_THAT(Create("b", options), StatusIs(absl::StatusCode::kNotFound, testing::_));
  EXPECT_THAT(Create("b", MazeOptions(8)), IsOk()) << "the rejected pool is not counted";
}

TEST_F(PoolSupervisorTest, PoolRejectedByTheEngineLeavesNothing) {
  PoolOptions options = MazeOptions(8);
  options.games = {"chess"};
  EXPECT_THAT(Create("a", options), StatusIs(absl::StatusCode::kNotFound, HasSubstr("chess")));
  EXPECT_EQ(supervisor_.load().env_count, 0);
  EXPECT_THAT(Create("a", MazeOptions(8)), IsOk());
}

TEST_F(PoolSupervisorTest, UnknownAndMalformedNamesHaveDifferentErrors) {
  EXPECT_THAT(supervisor_.Find("", "pools/nothing"),
              StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/nothing"));
  EXPECT_THAT(supervisor_.Find("", "nothing"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("pool name is 'nothing'")));
  EXPECT_THAT(supervisor_.Delete("", ""), StatusIs(absl::StatusCode::kInvalidArgument, testing::_));
}

TEST_F(PoolSupervisorTest, ListIsOldestFirstAndContinues) {
  ASSERT_THAT(Create("b", MazeOptions(1)), IsOk());
  ASSERT_THAT(Create("a", MazeOptions(1)), IsOk());
  const std::vector<PoolSupervisor::Numbered> page = supervisor_.List("", 0, 1);
  ASSERT_EQ(page.size(), 1U);
  EXPECT_EQ(page[0].pool->name(), "pools/b");
  const std::vector<PoolSupervisor::Numbered> rest = supervisor_.List("", page[0].number, 5);
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(rest[0].pool->name(), "pools/a");
}

TEST_F(PoolSupervisorTest, DrainRejectsNewPoolsAndEndsStreams) {
  const CreateResult pool = Create("a", MazeOptions(1));
  ASSERT_THAT(pool, IsOk());
  absl::Status ended;
  (*pool)->Attach(
      {}, [&](StreamEnd /*why*/, absl::Status reason) { ended = std::move(reason); },
      [](const absl::Status& status) { EXPECT_THAT(status, IsOk()); });
  supervisor_.Drain();
  EXPECT_THAT(ended, StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_THAT(Create("b", MazeOptions(1)),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_THAT(supervisor_.FindForStream("", "pools/a"),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  (*pool)->Detach();
}

TEST_F(PoolSupervisorTest, PoolIsFreedExactlyWhenItsLeaseExpires) {
  ASSERT_THAT(Create("short", MazeOptions(4), "", absl::Seconds(10)), IsOk());
  ASSERT_THAT(Create("long", MazeOptions(4), "", absl::Seconds(30)), IsOk());
  const absl::Time begin = clock_.Now();
  clock_.Advance(absl::Seconds(9));
  EXPECT_EQ(supervisor_.FreeExpired(clock_.Now()), begin + absl::Seconds(10));
  EXPECT_THAT(supervisor_.Find("", "pools/short"), IsOk());
  clock_.Advance(absl::Seconds(1));
  EXPECT_EQ(supervisor_.FreeExpired(clock_.Now()), begin + absl::Seconds(30));
  EXPECT_THAT(supervisor_.Find("", "pools/short"),
              StatusIs(absl::StatusCode::kNotFound, testing::_));
  EXPECT_THAT(supervisor_.Find("", "pools/long"), IsOk());
  EXPECT_EQ(supervisor_.load().env_count, 4);
  EXPECT_THAT(Create("short", MazeOptions(4)), IsOk()) << "its name and its capacity are free";
  EXPECT_THAT(metrics_.Text(), HasSubstr("procgen_pools_expired_total 1\n"));
}

TEST_F(PoolSupervisorTest, PoolWithoutALeaseStays) {
  ASSERT_THAT(Create("a", MazeOptions(1)), IsOk());
  clock_.Advance(absl::Hours(1000));
  EXPECT_EQ(supervisor_.FreeExpired(clock_.Now()), absl::InfiniteFuture());
  EXPECT_THAT(supervisor_.Find("", "pools/a"), IsOk());
}

TEST_F(PoolSupervisorTest, ReferenceToAFreedPoolReturnsAnError) {
  const CreateResult pool = Create("a", MazeOptions(1), "", absl::Seconds(1));
  ASSERT_THAT(pool, IsOk());
  clock_.Advance(absl::Seconds(1));
  supervisor_.FreeExpired(clock_.Now());
  absl::Status attached;
  (*pool)->Attach(
      {}, [](StreamEnd, const absl::Status&) {},
      [&](absl::Status status) { attached = std::move(status); });
  EXPECT_THAT(attached, StatusIs(absl::StatusCode::kNotFound,
                                 "there is no pool pools/a any more: its lease ran out"));
  EXPECT_THAT((*pool)->Renew(std::nullopt), StatusIs(absl::StatusCode::kNotFound, testing::_));
}

TEST_F(PoolSupervisorTest, LeasesAreWithinTheLimits) {
  Limits limits;
  EXPECT_THAT(CheckLeaseDuration("lease", absl::Seconds(1), limits), IsOk());
  EXPECT_THAT(CheckLeaseDuration("lease", absl::Hours(24), limits), IsOk());
  EXPECT_THAT(CheckLeaseDuration("lease", absl::Milliseconds(999), limits),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "lease is 999ms, allowed: 0 (no lease), or 1s to 24h"));
  limits.lease_duration_max = absl::Minutes(1);
  EXPECT_THAT(CheckLeaseDuration("lease", absl::Seconds(61), limits),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "lease is 1m1s, limit lease_duration_max is 1m"));
}

}  // namespace
}  // namespace procgen
