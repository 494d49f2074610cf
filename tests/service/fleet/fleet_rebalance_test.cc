// Rebalancing of pools over the nodes of a fleet.

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/fleet/pool/fleet_pool.h"
#include "server/wire/convert_pool.h"
#include "tests/service/fleet/fleet_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// The names of the shards on `nodes`. A name ends with the shard's number and its epoch.
std::set<std::string> ShardsOn(const std::vector<NodeStatus>& nodes) {
  std::set<std::string> shards;
  for (const NodeStatus& node : nodes) {
    const auto client = procgen_client::Client::Connect(node.address);
    EXPECT_THAT(client.status(), IsOk());
    const auto pools = (*client)->ListPools();
    EXPECT_THAT(pools, IsOk());
    for (const v1::Pool& shard : *pools) {
      shards.insert(shard.name());
    }
  }
  return shards;
}

NodeStatus ForgedNode(int number, const std::string& address) {
  NodeStatus forged;
  forged.node_id = absl::StrCat("forged-", number);
  forged.address = address;
  forged.environment_capacity = 1'000'000;  // the largest, so it is preferred
  forged.worker_count = 1;
  forged.healthy = true;
  return forged;
}

class FleetRebalanceTest : public FleetTest {};

// Tests the fleet pool without a fleet server, so that the test controls when it polls its nodes.
TEST_F(FleetRebalanceTest, PoolIsRebalancedOncePerJoin) {
  const std::thread::id test_thread = std::this_thread::get_id();
  std::atomic<bool> others_wait = true;
  std::atomic<int> poll_count = 0;
  FleetOptions options;
  options.nodes = [&] {
    // Lets the pool poll its nodes three times for each call from another thread: during a
    // rebalance, and while a shard leaves its node.
    const int until = poll_count + 3;
    while (std::this_thread::get_id() != test_thread && others_wait && poll_count < until) {
      absl::SleepFor(absl::Milliseconds(1));
    }
    return list_.Nodes();
  };
  StartNode("a");
  Metrics metrics("test");
  FleetNodes nodes(options);
  OrphanCollector orphan_collector("fleet-test-", &nodes);
  BackgroundExecutor executor(1);
  ShardThreadBudget threads(options.shard_threads_max);
  ShardContext context;
  context.id_prefix = "fleet-test-";
  context.options = &options;
  context.nodes = &nodes;
  context.orphan_collector = &orphan_collector;
  context.threads = &threads;
  context.metrics = &metrics;
  const auto pool_options = PoolOptionsOf(Script().spec);
  ASSERT_THAT(pool_options, IsOk());
  context.spec = PoolSpecMessageOf(*pool_options);
  FleetPool pool(*pool_options, StateValidator::Create(*pool_options).value(), context, &executor,
                 [](FleetPool* /*gone*/) {});
  const auto poll_until_done = [&](const std::function<void(PoolBackend::Done)>& begin) {
    absl::Notification done;
    begin([&done](const absl::Status& status) {
      EXPECT_THAT(status, IsOk());
      done.Notify();
    });
    while (!done.HasBeenNotified()) {
      pool.OnNodesChanged();
      ++poll_count;
    }
  };
  const auto assignments = nodes.PlanShards(pool.env_count());
  auto reserved = threads.Reserve(assignments->size());
  poll_until_done([&](PoolBackend::Done done) {
    pool.Begin(*assignments, *std::move(reserved), std::move(done));
  });
  StartNode("b");
  ASSERT_THAT(nodes.Connect("b"), IsOk());
  Request request;
  request.kind = Request::Kind::kStep;
  request.count = pool.env_count();
  const std::vector<int32_t> actions(static_cast<size_t>(pool.env_count()), 7);
  request.actions = actions;
  for (int i = 0; i < 20; ++i) {
    poll_until_done([&](PoolBackend::Done done) {
      pool.BeginRequest(request, {});
      pool.StepAsync({.count = request.count}, {}, std::move(done));
    });
  }
  others_wait = false;
  const std::set<std::string> shards = ShardsOn(list_.Nodes());
  EXPECT_THAT(shards, testing::IsSupersetOf({"pools/fleet-test-2-1", "pools/fleet-test-3-1"}));
  EXPECT_THAT(shards, testing::Not(testing::Contains(testing::HasSubstr("-4-"))));
}

TEST_F(FleetRebalanceTest, RebalanceUsesConnectedNodesAndCountsOwnCapacity) {
  StartNode("a");
  StartNode("b");
  for (NodeStatus node : list_.Nodes()) {
    node.environment_capacity = 24;
    node.env_count = node.node_id == "a" ? 24 : 0;
    list_.Set(node);
  }
  list_.Set(ForgedNode(1, "127.0.0.1:1"));
  FleetOptions options;
  options.nodes = [this] { return list_.Nodes(); };
  FleetNodes nodes(options);
  const auto counts = [&nodes] {
    std::map<std::string, int32_t> counts;
    const auto assignments = nodes.PlanRebalance(24, {{"a", 24}});
    EXPECT_THAT(assignments, IsOk());
    for (const ShardAssignment& assignment : *assignments) {
      counts[assignment.node_id] = assignment.env_count;
    }
    return counts;
  };
  EXPECT_THAT(nodes.PlanRebalance(24, {{"a", 24}}),
              StatusIs(absl::StatusCode::kUnavailable, testing::_));
  ASSERT_THAT(nodes.Connect("a"), IsOk());
  EXPECT_THAT(nodes.Connect("forged-1"), StatusIs(absl::StatusCode::kUnavailable, testing::_));
  EXPECT_EQ(counts(), (std::map<std::string, int32_t>{{"a", 24}}));
  ASSERT_THAT(nodes.Connect("b"), IsOk());
  EXPECT_EQ(counts(), (std::map<std::string, int32_t>{{"a", 12}, {"b", 12}}));
}

TEST_F(FleetRebalanceTest, ShardThreadsAreLimited) {
  StartNode("a");
  StartNode("b");
  adjust_ = [](FleetOptions* options) { options->shard_threads_max = 3; };
  StartFleet();
  const auto client = Connect(*server_);
  const auto create = [&client](const std::string& id) {
    return client->CreatePool(Script().spec, id).status();
  };
  EXPECT_THAT(create("wide"), IsOk());
  EXPECT_EQ(ShardsOn(list_.Nodes()).size(), 2);
  EXPECT_THAT(create("narrow"), IsOk());
  EXPECT_EQ(ShardsOn(list_.Nodes()).size(), 3) << "there was one thread left";
  EXPECT_THAT(create("none"), StatusIs(absl::StatusCode::kResourceExhausted,
                                       testing::HasSubstr("the fleet runs 3 shards, limit 3")));
  EXPECT_THAT(client->DeletePool("pools/wide"), IsOk());
  absl::Status again = create("again");
  while (absl::IsResourceExhausted(again)) {  // until the deleted pool's shards have ended
    again = create("again");
  }
  EXPECT_THAT(again, IsOk());
}

struct ThreadCase {
  int32_t threads_max;
  size_t shard_count;  // after a node joins
};

class FleetThreadsTest : public FleetRebalanceTest,
                         public testing::WithParamInterface<ThreadCase> {};

// New shards start before the old one ends.
TEST_P(FleetThreadsTest, RebalanceNeedsThreadsForNewShards) {
  StartNode("a");
  poll_interval_ = absl::Milliseconds(20);
  adjust_ = [](FleetOptions* options) { options->shard_threads_max = GetParam().threads_max; };
  StartFleet();
  ExpectSameTrace(Script(), [&](int index) {
    if (index == 50) {
      StartNode("b");
    }
    if (index > 50 && index < 150) {
      absl::SleepFor(absl::Milliseconds(10));  // a learner that thinks, while nodes are polled
    }
    if (index == 350) {
      EXPECT_EQ(ShardsOn(list_.Nodes()).size(), GetParam().shard_count);
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Limits, FleetThreadsTest,
                         testing::Values(ThreadCase{2, 1}, ThreadCase{3, 2}));

// A participant of the cluster announces unreachable nodes. The failover of node c, before that, is
// the yardstick for the failover of node b.
TEST_F(FleetRebalanceTest, ForgedNodesCauseNoMigrationAndNoDelay) {
  poll_interval_ = absl::Milliseconds(20);
  StartNode("a");
  StartNode("b");
  const std::vector<NodeStatus> real = list_.Nodes();
  StartNode("c");
  StartFleet();
  std::set<std::string> before;
  std::set<std::string> after;
  absl::Time killed;
  absl::Duration pause_without_forged_nodes;
  absl::Duration pause;
  ExpectSameTrace(Script(), [&](int index) {
    if (index == 30) {
      nodes_.erase("c");
      killed = SteadyNow();
    }
    if (index == 40) {
      pause_without_forged_nodes = SteadyNow() - killed;
      list_.Remove("c");
    }
    // The environments are divided again, into one shard per node.
    if (index % 10 == 0 && index > 40 && index <= 150 && before.size() != 2) {
      before = ShardsOn(real);
      if (before.size() == 2) {
        for (int i = 0; i < 100; ++i) {
          list_.Set(ForgedNode(i, "127.0.0.1:1"));
        }
      }
    }
    if (index > 40 && index < 250) {
      absl::SleepFor(absl::Milliseconds(10));  // a learner that thinks, while nodes are polled
    }
    if (index == 300) {
      after = ShardsOn(real);
      nodes_.erase("b");
      killed = SteadyNow();
    }
    if (index == 310) {
      pause = SteadyNow() - killed;
    }
  });
  EXPECT_EQ(before.size(), 2);
  EXPECT_EQ(after, before) << "shards have moved";
  EXPECT_THAT(MetricsText(), testing::HasSubstr("procgen_fleet_shard_migrations_total 2\n"));
  EXPECT_LT(pause, 2 * pause_without_forged_nodes + absl::Milliseconds(500))
      << "forged nodes were tried before the real one";
}

}  // namespace
}  // namespace procgen
