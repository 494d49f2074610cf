// A fleet as its operator has it: nodes, fleet server and learner, each a process but the learner,
// in a real cluster. What the learner sees is what one server would show it.

#include <csignal>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/algorithm/container.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "gtest/gtest.h"
#include "tests/server/cluster/cluster_watch.h"
#include "tests/service/scripted_learner.h"
#include "tests/service/server_process.h"
#include "tests/service/test_fleet.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

LearnerScript Script(int request_count = 1500) {
  LearnerScript script;
  script.request_count = request_count;
  for (const char* game : {"coinrun", "starpilot", "maze"}) {
    script.spec.add_games(game);
  }
  script.spec.set_env_count(24);
  script.spec.mutable_options()->set_rand_seed(3);
  return script;
}

LearnerTrace SingleServerTrace(const LearnerScript& script) {
  ServerProcess single({"--address=127.0.0.1:0", "--log_level=error"});
  const auto client = procgen_client::Client::Connect(single.Address()).value();
  const auto trace = PlayScript(script, client.get(), [](int) {});
  EXPECT_THAT(trace, IsOk());
  return trace.value();
}

void ExpectSameTrace(const LearnerScript& script, const TestFleet& fleet,
                     const std::function<void(int)>& faults) {
  const LearnerTrace expected = SingleServerTrace(script);
  const auto actual = PlayScript(script, fleet.Connect().get(), faults);
  ASSERT_THAT(actual, IsOk());
  EXPECT_EQ(FirstDifference(expected, *actual), -1);
}

TEST(FleetClusterTest, NodesDieStopDrainAndComeAndNobodyNotices) {
  TestFleet fleet;
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartNode("c");
  fleet.StartFleet(3);
  std::unique_ptr<ServerProcess> drained;
  ExpectSameTrace(Script(), fleet, [&](int index) {
    if (index == 200) {
      fleet.KillNode("a");
    }
    if (index == 500) {
      fleet.node("b").Signal(SIGSTOP);
    }
    if (index == 600) {
      fleet.node("b").Signal(SIGCONT);
      fleet.StartNode("d");
    }
    if (index == 1000) {
      drained = fleet.TakeNode("c");
      drained->Signal(SIGTERM);
    }
  });
  const absl::Time begin = absl::Now();
  EXPECT_EQ(drained->Wait(), 0);
  EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "its shards were not taken away";
}

TEST(FleetClusterTest, AnIdlePoolLeavesADrainingNode) {
  TestFleet fleet;
  fleet.StartNode("a");
  fleet.StartFleet(1);
  const auto client = fleet.Connect();
  ASSERT_THAT(client->CreatePool(Script().spec), IsOk());
  fleet.StartNode("b");
  const auto drained = fleet.TakeNode("a");
  drained->Signal(SIGTERM);
  const absl::Time begin = absl::Now();
  EXPECT_EQ(drained->Wait(), 0);
  EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "its shards were not taken away";
}

// The nodes that the shards of a pool are told to be on, in the order of their numbers.
std::vector<std::string> NodesOf(const std::vector<PoolPlacement>& placements,
                                 const std::string& pool) {
  std::vector<std::string> nodes;
  for (const PoolPlacement& placement : placements) {
    if (placement.fleet_id == "fleet" && placement.pool == pool) {
      nodes.push_back(placement.node_id);
    }
  }
  return nodes;
}

TEST(FleetClusterTest, TheClusterIsToldWhereShardsAre) {
  TestFleet fleet;
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartFleet(2);
  const auto cluster = fleet.JoinCluster("witness");
  ClusterWatch watch(cluster.get());
  const auto client = fleet.Connect();
  const auto pool = client->CreatePool(Script().spec);
  ASSERT_THAT(pool, IsOk());
  const auto nodes = [&] { return NodesOf(cluster->Placements(), pool->name()); };
  EXPECT_TRUE(watch.Await([&] {
    return absl::c_is_permutation(nodes(), std::vector<std::string>{"a", "b"});
  })) << absl::StrJoin(nodes(), " ");

  fleet.KillNode("a");
  EXPECT_TRUE(watch.Await([&] {
    return nodes() == std::vector<std::string>{"b", "b"};
  })) << absl::StrJoin(nodes(), " ");
  int64_t epochs = 0;
  for (const PoolPlacement& placement : cluster->Placements()) {
    epochs += placement.epoch;
  }
  EXPECT_EQ(epochs, 1 + 2) << "one has moved";

  EXPECT_THAT(client->DeletePool(pool->name()), IsOk());
  EXPECT_TRUE(watch.Await([&] { return nodes().empty(); })) << absl::StrJoin(nodes(), " ");
}

struct Restart {
  v1::Encoding encoding;
  bool is_killed = true;  // or else stopped
};

class FleetRestartTest : public testing::TestWithParam<Restart> {};

TEST_P(FleetRestartTest, AFleetServerGoesOnWhereItWas) {
  const TemporaryFolder folder;
  TestFleet fleet({absl::StrCat("--state_dir=", folder.path())});
  fleet.StartNode("a");
  fleet.StartNode("b");
  fleet.StartFleet(2);
  LearnerScript script = Script();
  script.with_states = false;  // those calls are not repeated by the client
  script.spec.set_encoding(GetParam().encoding);
  std::thread operator_thread;
  ExpectSameTrace(script, fleet, [&](int index) {
    if (index % 500 != 250) {
      return;
    }
    if (operator_thread.joinable()) {
      operator_thread.join();
    }
    // While requests are under way.
    operator_thread = std::thread([&fleet] {
      if (GetParam().is_killed) {
        fleet.KillFleet();
      } else {
        const absl::Time begin = absl::Now();
        fleet.StopFleet();
        EXPECT_LT(absl::Now() - begin, absl::Seconds(15)) << "it waited for the learner";
      }
      fleet.StartFleet(2);
    });
  });
  operator_thread.join();
}

INSTANTIATE_TEST_SUITE_P(KilledAndStopped, FleetRestartTest,
                         testing::Values(Restart{v1::ENCODING_RAW, true},
                                         Restart{v1::ENCODING_LZ4_DIFFERENCE, true},
                                         Restart{v1::ENCODING_RAW, false}));

TEST(FleetFlagsTest, WrongFlagsAreTold) {
  for (const auto& [flags, message] :
       {std::pair<std::vector<std::string>, std::string>({"--fleet"}, "--cluster"),
        std::pair<std::vector<std::string>, std::string>({"--state_dir=/tmp"},
                                                         "--fleet is missing"),
        std::pair<std::vector<std::string>, std::string>(
            {"--fleet", "--cluster=x", "--fleet_token=/nowhere"}, "--fleet_token is /nowhere")}) {
    ServerProcess process(flags);
    EXPECT_EQ(process.Address(), "");
    EXPECT_EQ(process.Wait(), 2);
    EXPECT_NE(process.beginning().find(message), std::string::npos) << process.beginning();
  }
}

}  // namespace
}  // namespace procgen
