#include "server/fleet/nodes/fleet_nodes.h"

#include <map>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"
#include "tests/wall_clock/wall_clock.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

NodeStatus Node(const std::string& node_id, int32_t capacity, int32_t used = 0) {
  NodeStatus node;
  node.node_id = node_id;
  node.environment_capacity = capacity;
  node.env_count = used;
  node.worker_count = 2;
  node.healthy = true;
  return node;
}

FleetOptions OptionsOf(const std::vector<NodeStatus>& nodes) {
  FleetOptions options;
  options.nodes = [nodes] { return nodes; };
  return options;
}

using Counts = std::vector<std::pair<std::string, int32_t>>;

Counts CountsOf(const absl::StatusOr<std::vector<ShardAssignment>>& assignments) {
  EXPECT_THAT(assignments, IsOk());
  Counts counts;
  for (const ShardAssignment& assignment : *assignments) {
    counts.emplace_back(assignment.node_id, assignment.env_count);
  }
  return counts;
}

Counts Plan(const std::vector<NodeStatus>& nodes, int32_t env_count) {
  return CountsOf(FleetNodes(OptionsOf(nodes)).PlanShards(env_count));
}

TEST(PlanShardsTest, EqualNodesHaveEqualShares) {
  EXPECT_THAT(Plan({Node("a", 100), Node("b", 100), Node("c", 100)}, 24),
              ElementsAre(Pair("a", 8), Pair("b", 8), Pair("c", 8)));
}

TEST(PlanShardsTest, RemainderGoesToTheFirstNodes) {
  EXPECT_THAT(Plan({Node("a", 100), Node("b", 100), Node("c", 100)}, 26),
              ElementsAre(Pair("a", 9), Pair("b", 9), Pair("c", 8)));
}

TEST(PlanShardsTest, SharesFollowTheFreeCapacity) {
  EXPECT_THAT(Plan({Node("a", 100, 50), Node("b", 200, 50), Node("c", 400, 400)}, 80),
              ElementsAre(Pair("b", 60), Pair("a", 20)));
}

TEST(PlanShardsTest, NoNodeExceedsItsCapacity) {
  EXPECT_THAT(Plan({Node("a", 7), Node("b", 5), Node("c", 1)}, 13),
              ElementsAre(Pair("a", 7), Pair("b", 5), Pair("c", 1)));
}

TEST(PlanShardsTest, NodeCountIsLimited) {
  const FleetNodes nodes(OptionsOf({Node("a", 30), Node("b", 20), Node("c", 10)}));
  EXPECT_THAT(CountsOf(nodes.PlanShards(24, 2)), ElementsAre(Pair("a", 15), Pair("b", 9)));
  EXPECT_THAT(nodes.PlanShards(40, 1).status(),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("threads left for 1 shards, whose nodes have room for 30")));
}

TEST(PlanShardsTest, DrainingUnhealthyAndFullNodesGetNoShard) {
  NodeStatus draining = Node("a", 100);
  draining.draining = true;
  NodeStatus unwell = Node("b", 100);
  unwell.healthy = false;
  EXPECT_THAT(Plan({draining, unwell, Node("fleet", 0), Node("d", 100)}, 16),
              ElementsAre(Pair("d", 16)));
}

TEST(PlanShardsTest, FewEnvironmentsStayTogether) {
  const std::vector<NodeStatus> nodes = {Node("a", 100), Node("b", 100), Node("c", 100)};
  EXPECT_THAT(Plan(nodes, 1), ElementsAre(Pair("a", 1)));
  EXPECT_THAT(Plan(nodes, 7), ElementsAre(Pair("a", 7)));
  EXPECT_THAT(Plan(nodes, 8), ElementsAre(Pair("a", 4), Pair("b", 4)));
}

TEST(PlanShardsTest, FewEnvironmentsAreSplitIfCapacityRequires) {
  EXPECT_THAT(Plan({Node("a", 3), Node("b", 3), Node("c", 3)}, 8),
              ElementsAre(Pair("a", 3), Pair("b", 3), Pair("c", 2)));
}

TEST(PlanShardsTest, ErrorsNameTheCapacity) {
  EXPECT_THAT(FleetNodes(OptionsOf({})).PlanShards(8),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("no node at the moment")));
  EXPECT_THAT(FleetNodes(OptionsOf({Node("a", 10, 4), Node("b", 3, 9)})).PlanShards(8),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "spec.env_count is 8 and the fleet's nodes have room for 6 environments"));
}

TEST(FleetNodesTest, CapacityIsReservedUntilTheReservationIsDestroyed) {
  FleetNodes nodes(OptionsOf({Node("a", 10), Node("b", 10)}));
  {
    auto reserved = nodes.Reserve(8, "b");
    ASSERT_THAT(reserved, IsOk());
    EXPECT_EQ(reserved->node_id(), "b");
    EXPECT_THAT(CountsOf(nodes.PlanShards(12)), ElementsAre(Pair("a", 10), Pair("b", 2)));
    const auto elsewhere = nodes.Reserve(8, "b");
    ASSERT_THAT(elsewhere, IsOk());
    EXPECT_EQ(elsewhere->node_id(), "a") << "preferred nodes have no capacity";
    EXPECT_THAT(nodes.Reserve(8, "b"), StatusIs(absl::StatusCode::kUnavailable,
                                                "none of 2 nodes has room for 8 environments"));
    const FleetNodes::CapacityReservation moved = *std::move(reserved);
    EXPECT_EQ(moved.node_id(), "b");
  }
  EXPECT_THAT(CountsOf(nodes.PlanShards(20)), ElementsAre(Pair("a", 10), Pair("b", 10)));
}

TEST(FleetNodesTest, SuspectsAreUsedAsTheLastResort) {
  FleetNodes nodes(OptionsOf({Node("a", 100), Node("b", 10)}));
  nodes.Suspect("a");
  EXPECT_EQ(nodes.Reserve(4, "a")->node_id(), "b");
  nodes.Suspect("b");
  EXPECT_EQ(nodes.Reserve(4, "a")->node_id(), "a");
}

TEST(FleetNodesTest, WrongResponsesExcludeANodeWithDoublingBackoff) {
  absl::Time now = absl::UnixEpoch();
  FleetOptions options = OptionsOf({Node("a", 100)});
  options.clock = [&now] { return now; };
  FleetNodes nodes(options);
  for (const int seconds : {1, 2, 4, 8, 16, 32, 64, 128, 256, 300, 300}) {
    EXPECT_THAT(nodes.Distrust("a", absl::DataLossError("batch.rewards is empty")),
                StatusIs(absl::StatusCode::kUnavailable,
                         "node a sent an invalid answer: batch.rewards is empty"));
    now += absl::Seconds(seconds) - absl::Nanoseconds(1);
    EXPECT_THAT(nodes.Reserve(4, "a"), StatusIs(absl::StatusCode::kUnavailable, testing::_));
    now += absl::Nanoseconds(1);
    EXPECT_THAT(nodes.Reserve(4, "a"), IsOk());
  }
  now += absl::Minutes(10);
  nodes.Distrust("a", absl::DataLossError("again")).IgnoreError();
  now += absl::Seconds(1);
  EXPECT_THAT(nodes.Reserve(4, "a"), IsOk()) << "old errors are forgotten";
}

TEST(FleetNodesTest, OldNodesAreForgotten) {
  absl::Time now = absl::UnixEpoch();
  std::string node_id;
  FleetOptions options;
  options.nodes = [&node_id] { return std::vector<NodeStatus>{Node(node_id, 100)}; };
  options.clock = [&now] { return now; };
  FleetNodes nodes(options);
  for (int i = 0; i < 1000; ++i) {
    node_id = absl::StrCat("node-", i);
    EXPECT_THAT(nodes.Reserve(8, node_id), IsOk());
    nodes.Suspect(node_id);
    nodes.Distrust(node_id, absl::DataLossError("some nonsense")).IgnoreError();
    nodes.OnNodesChanged();
    now += absl::Minutes(1);
  }
  EXPECT_LE(nodes.known_count(), 7);
}

class SetClockTest : public testing::TestWithParam<absl::Duration> {
 protected:
  ~SetClockTest() override { SetWallClockOffset(0); }
};

TEST_P(SetClockTest, WaitsForNodesEndAtTheirTimeout) {
  const FleetNodes nodes(OptionsOf({}));
  std::thread operator_thread([] { SetWallClockOffset(absl::ToInt64Nanoseconds(GetParam())); });
  const absl::Time begin = SteadyNow();
  nodes.AwaitChange(begin + absl::Milliseconds(300));
  EXPECT_GE(SteadyNow() - begin, absl::Milliseconds(300));
  operator_thread.join();
}

INSTANTIATE_TEST_SUITE_P(BackAndForth, SetClockTest,
                         testing::Values(-absl::Hours(1), absl::Hours(1)));

TEST(FleetNodesTest, OnlyServingNodesAreUsable) {
  NodeStatus draining = Node("b", 100);
  draining.draining = true;
  const FleetNodes nodes(OptionsOf({Node("a", 100), draining, Node("fleet", 0)}));
  EXPECT_TRUE(nodes.IsUsable("a"));
  EXPECT_FALSE(nodes.IsUsable("b"));
  EXPECT_TRUE(nodes.IsPresent("b"));
  EXPECT_FALSE(nodes.IsUsable("gone"));
  EXPECT_FALSE(nodes.IsPresent("gone"));
  EXPECT_THAT(nodes.Present(), ElementsAre("a", "b"));
  EXPECT_EQ(nodes.worker_count(), 2);
}

}  // namespace
}  // namespace procgen
