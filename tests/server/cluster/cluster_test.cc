// Clusters of nodes in this process. Each node is a DDS participant, and they communicate over
// loopback as processes do.

#include "server/cluster/cluster.h"

#include <unistd.h>

#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/concurrency/steady_time.h"
#include "tests/server/cluster/await.h"
#include "tests/server/cluster/publisher.h"
#include "tests/server/cluster/test_options.h"
#include "tests/status_matchers.h"
#include "tests/wall_clock/wall_clock.h"

// Cyclone DDS leaks two blocks where a participant cannot be created.
// NOLINTNEXTLINE(bugprone-reserved-identifier): the sanitizer's name
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions() {
  return "leak:ddsrt_malloc\n";
}

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::unique_ptr<Cluster> Join(const ClusterOptions& options) {
  absl::StatusOr<std::unique_ptr<Cluster>> cluster = Cluster::Join(options);
  EXPECT_THAT(cluster.status(), IsOk());
  return *std::move(cluster);
}

NodeStatus SomeStatus(const std::string& address) {
  NodeStatus status;
  status.address = address;
  status.server_version = "1.2.3";
  status.environment_capacity = 64;
  status.env_count = 32;
  status.pool_count = 3;
  status.worker_count = 4;
  status.steps_per_second = 1234.5;
  status.healthy = true;
  status.draining = true;
  return status;
}

std::vector<std::string> IdsOf(const std::vector<NodeStatus>& nodes) {
  std::vector<std::string> ids;
  ids.reserve(nodes.size());
  for (const NodeStatus& node : nodes) {
    ids.push_back(node.node_id);
  }
  return ids;
}

using Ids = std::vector<std::string>;

bool AwaitIds(const Cluster* cluster, const Ids& ids, absl::Duration timeout = absl::Seconds(20)) {
  return Await([&] { return IdsOf(cluster->Nodes()) == ids; }, timeout);
}

TEST(ClusterTest, NodeIsListedOnceItHasPublished) {
  const auto cluster = Join(TestOptions("a"));
  EXPECT_THAT(cluster->Nodes(), IsEmpty());
  cluster->Publish(SomeStatus("127.0.0.1:1"));
  NodeStatus expected = SomeStatus("127.0.0.1:1");
  expected.node_id = "a";
  EXPECT_THAT(cluster->Nodes(), ElementsAre(expected));
}

TEST(ClusterTest, ChangesAreReceived) {
  const auto a = Join(TestOptions("a"));
  const auto b = Join(TestOptions("b"));
  b->Publish(SomeStatus("127.0.0.1:2"));
  EXPECT_TRUE(AwaitIds(a.get(), {"b"}));
  NodeStatus status = SomeStatus("127.0.0.1:3");
  status.draining = false;
  b->Publish(status);
  EXPECT_TRUE(Await(
      [&] { return a->Nodes().front().address == "127.0.0.1:3" && !a->Nodes().front().draining; }));
}

TEST(ClusterTest, LeavingNodeDisappearsAtOnce) {
  const auto a = Join(TestOptions("a"));
  auto b = Join(TestOptions("b"));
  b->Publish(SomeStatus("127.0.0.1:2"));
  EXPECT_TRUE(AwaitIds(a.get(), {"b"}));
  b = nullptr;
  // Well within the lease.
  EXPECT_TRUE(AwaitIds(a.get(), {}, kNodeLease / 2));
}

TEST(ClusterTest, SilentNodeDisappearsThoughItRuns) {
  const auto a = Join(TestOptions("a"));
  const auto b = Join(TestOptions("b"));
  const Publisher publisher(a.get(), SomeStatus("127.0.0.1:1"));
  b->Publish(SomeStatus("127.0.0.1:2"));
  EXPECT_TRUE(AwaitIds(a.get(), {"a", "b"}));
  EXPECT_TRUE(AwaitIds(a.get(), {"a"}, 2 * kNodeLease));
  b->Publish(SomeStatus("127.0.0.1:2"));
  EXPECT_TRUE(AwaitIds(a.get(), {"a", "b"}));
}

TEST(ClusterTest, NodesThatPublishNothingNewStay) {
  const auto a = Join(TestOptions("a"));
  const auto b = Join(TestOptions("b"));
  const Publisher publisher_a(a.get(), SomeStatus("127.0.0.1:1"));
  const Publisher publisher_b(b.get(), SomeStatus("127.0.0.1:2"));
  EXPECT_TRUE(AwaitIds(a.get(), {"a", "b"}));
  EXPECT_FALSE(Await(
      [&] {
        return IdsOf(a->Nodes()) != Ids{"a", "b"};
      },
      kPublishTimeout + kNodeLease));
}

TEST(ClusterTest, ChangesOfTheRateArriveWithTheNextRepetition) {
  const auto a = Join(TestOptions("a"));
  const auto b = Join(TestOptions("b"));
  for (const double rate : {1000.0, 1001.0, 0.0}) {
    NodeStatus status = SomeStatus("127.0.0.1:2");
    status.steps_per_second = rate;
    const Publisher publisher(b.get(), status);
    EXPECT_TRUE(
        Await([&] { return !a->Nodes().empty() && a->Nodes()[0].steps_per_second == rate; }));
  }
}

TEST(ClusterTest, PeersFindAsManyNodesOfAMachineAsAreAllowed) {
  std::vector<std::unique_ptr<Cluster>> nodes;
  ClusterOptions options = TestOptions("");
  options.peers = {"127.0.0.1"};
  Ids ids;
  for (int i = 0; i < kNodesOfPeerMax; ++i) {
    options.node_id = ids.emplace_back(absl::StrCat("node-", i));
    nodes.push_back(Join(options));
    nodes.back()->Publish(SomeStatus("127.0.0.1:1"));
  }
  for (const auto& node : nodes) {
    EXPECT_TRUE(AwaitIds(node.get(), ids));
  }
  EXPECT_THAT(Cluster::Join(options).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("cannot join cluster")));
}

TEST(ClusterTest, ClustersWithDifferentNamesAreSeparate) {
  const auto a = Join(TestOptions("a"));
  ClusterOptions elsewhere = TestOptions("b");
  elsewhere.name += ".";
  const auto b = Join(elsewhere);
  const auto c = Join(TestOptions("c"));
  b->Publish(SomeStatus("127.0.0.1:2"));
  a->Publish(SomeStatus("127.0.0.1:1"));
  c->Publish(SomeStatus("127.0.0.1:3"));
  EXPECT_TRUE(AwaitIds(a.get(), {"a", "c"}));
  EXPECT_THAT(IdsOf(b->Nodes()), ElementsAre("b"));
}

TEST(ClusterTest, ReplacementNodeStaysWhenTheOldOneLeaves) {
  const auto a = Join(TestOptions("a"));
  auto before = Join(TestOptions("b"));
  const auto after = Join(TestOptions("b"));
  const auto await_address = [&](const std::string& address) {
    return Await([&] { return a->Nodes().size() == 1 && a->Nodes()[0].address == address; });
  };
  before->Publish(SomeStatus("127.0.0.1:2"));
  EXPECT_TRUE(await_address("127.0.0.1:2"));
  after->Publish(SomeStatus("127.0.0.1:3"));
  EXPECT_TRUE(await_address("127.0.0.1:3"));
  before = nullptr;
  after->Publish(SomeStatus("127.0.0.1:4"));  // after the other node left
  EXPECT_TRUE(await_address("127.0.0.1:4"));
}

TEST(ClusterTest, PeersWithNewAddressesStayListed) {
  const auto b = Join(TestOptions("b"));
  ClusterOptions options = TestOptions("a");
  options.peers = {"nodes"};
  std::atomic<int> asked = 0;
  const auto a = *Cluster::Join(options, [&](const std::string& host) {
    EXPECT_EQ(host, "nodes");
    // One address more than there are nodes, so the node keeps resolving.
    return ++asked == 1 ? Ids() : Ids{"127.0.0.1", "127.0.0.2", "127.0.0.3"};
  });
  {
    const Publisher publisher_a(a.get(), SomeStatus("127.0.0.1:1"));
    const Publisher publisher_b(b.get(), SomeStatus("127.0.0.1:2"));
    ASSERT_TRUE(AwaitIds(a.get(), {"a", "b"}));
    ASSERT_TRUE(AwaitIds(b.get(), {"a", "b"}));
  }
  bool lost = false;
  // The third resolution shows that the new addresses were used.
  NodeStatus status = SomeStatus("127.0.0.1:1");
  EXPECT_TRUE(Await([&] {
    ++status.pool_count;
    a->Publish(status);
    b->Publish(status);
    lost = lost || IdsOf(a->Nodes()) != Ids{"a", "b"} || IdsOf(b->Nodes()) != Ids{"a", "b"};
    return asked >= 3;
  }));
  status.pool_count = 0;
  a->Publish(status);
  EXPECT_TRUE(Await([&] { return b->Nodes()[0].pool_count == 0; }));
  EXPECT_FALSE(lost);
}

TEST(ClusterTest, PeersFindEachOtherWithoutMulticast) {
  ClusterOptions options = TestOptions("a");
  options.peers = {"localhost", "no-such-host.invalid"};
  const auto a = Join(options);
  options.node_id = "b";
  const auto b = Join(options);
  a->Publish(SomeStatus("127.0.0.1:1"));
  EXPECT_TRUE(AwaitIds(b.get(), {"a"}));
}

TEST(ClusterTest, PeersAreResolvedAgainDespiteAClockChange) {
  ClusterOptions options = TestOptions("a");
  options.peers = {"nodes"};
  std::atomic<int> count = 0;
  const HostResolver resolve = [&count](const std::string& /*host*/) {
    ++count;
    return std::vector<std::string>{"127.0.0.1"};
  };
  const auto cluster = Cluster::Join(options, resolve);
  ASSERT_THAT(cluster.status(), IsOk());
  SetWallClockOffset(-absl::ToInt64Nanoseconds(absl::Hours(1)));
  const absl::Time end = SteadyNow() + absl::Seconds(30);
  while (count < 3 && SteadyNow() < end) {
    absl::SleepFor(absl::Milliseconds(10));
  }
  SetWallClockOffset(0);
  EXPECT_GE(count, 3);
}

}  // namespace
}  // namespace procgen
