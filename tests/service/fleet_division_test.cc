// When a pool is divided anew among the nodes of a fleet.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/fleet/fleet_pool.h"
#include "server/rpc/convert_pool.h"
#include "tests/service/fleet_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

class FleetDivisionTest : public FleetTest {};

// The fleet pool alone, so that the test decides when it looks at its nodes.
TEST_F(FleetDivisionTest, APoolIsDividedOnceThoughNodesAreLookedAtMeanwhile) {
  const std::thread::id test_thread = std::this_thread::get_id();
  std::atomic<bool> others_wait = true;
  std::atomic<int> look_count = 0;
  FleetOptions options;
  options.nodes = [&] {
    // The pool looks at its nodes several times while anything else asks for them once: while it
    // is divided, and while a shard leaves its node.
    const int until = look_count + 3;
    while (std::this_thread::get_id() != test_thread && others_wait && look_count < until) {
      absl::SleepFor(absl::Milliseconds(1));
    }
    return list_.Nodes();
  };
  StartNode("a");
  Metrics metrics("test");
  FleetNodes nodes(options);
  Leftovers leftovers("fleet-test-", &nodes);
  BackgroundExecutor executor(1);
  ShardTerms terms;
  terms.id_prefix = "fleet-test-";
  terms.options = &options;
  terms.nodes = &nodes;
  terms.leftovers = &leftovers;
  terms.metrics = &metrics;
  const auto pool_options = PoolOptionsOf(Script().spec);
  ASSERT_THAT(pool_options, IsOk());
  terms.spec = PoolSpecMessageOf(*pool_options);
  FleetPool pool(*pool_options, FleetPool::Check(*pool_options).value(), terms, &executor,
                 [](FleetPool* /*gone*/) {});
  const auto look_until_done = [&](const std::function<void(HostedPool::Done)>& begin) {
    absl::Notification done;
    begin([&done](const absl::Status& status) {
      EXPECT_THAT(status, IsOk());
      done.Notify();
    });
    while (!done.HasBeenNotified()) {
      pool.Look();
      ++look_count;
    }
  };
  const auto shares = nodes.Divide(pool.env_count());
  look_until_done([&](HostedPool::Done done) { pool.Begin(*shares, std::move(done)); });
  StartNode("b");
  Request request;
  request.kind = Request::Kind::kStep;
  request.count = pool.env_count();
  const std::vector<int32_t> actions(static_cast<size_t>(pool.env_count()), 7);
  request.actions = actions;
  for (int i = 0; i < 20; ++i) {
    look_until_done([&](HostedPool::Done done) {
      pool.BeginRequest(request, {});
      pool.StepAsync({.count = request.count}, {}, std::move(done), nullptr);
    });
  }
  others_wait = false;
  std::vector<std::string> shards;  // their numbers in the life of the pool, and their epochs
  for (const NodeStatus& node : list_.Nodes()) {
    const auto pools = Connect(node.address)->ListPools();
    ASSERT_THAT(pools, IsOk());
    for (const v1::Pool& shard : *pools) {
      shards.push_back(shard.name());
    }
  }
  EXPECT_THAT(shards, testing::IsSupersetOf({"pools/fleet-test-2-1", "pools/fleet-test-3-1"}));
  EXPECT_THAT(shards, testing::Not(testing::Contains(testing::HasSubstr("-4-"))));
}

}  // namespace
}  // namespace procgen
