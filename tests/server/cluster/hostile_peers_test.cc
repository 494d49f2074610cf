// Hostile peers: a participant that forges nodes with well-formed samples.
// Every process that reaches the ports of a domain can write to it.

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/cluster/cluster.h"
#include "server/cluster/participant.h"
#include "tests/server/cluster/await.h"
#include "tests/server/cluster/test_options.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// Publishes this status, as a participant may do of any node.
absl::Status Forge(const Participant& forger, const NodeStatus& status) {
  return forger.Write(status);
}

NodeStatus Node(const std::string& node_id) {
  NodeStatus status;
  status.node_id = node_id;
  status.address = "127.0.0.1:1";
  status.server_version = "1.2.3";
  status.environment_capacity = 64;
  status.worker_count = 4;
  status.healthy = true;
  return status;
}

std::vector<std::string> IdsOf(const Cluster& cluster) {
  std::vector<std::string> ids;
  for (const NodeStatus& node : cluster.Nodes()) {
    ids.push_back(node.node_id);
  }
  return ids;
}

std::unique_ptr<Cluster> Join(const std::string& node_id) {
  auto cluster = Cluster::Join(TestOptions(node_id));
  EXPECT_THAT(cluster.status(), IsOk());
  (*cluster)->Publish(Node(node_id));
  return *std::move(cluster);
}

std::vector<NodeStatus> StatusesThatMakeNoSense() {
  constexpr int32_t kMax = std::numeric_limits<int32_t>::max();
  std::vector<NodeStatus> statuses;
  for (const std::string& node_id : {std::string(), std::string("two words"), std::string("a\nb"),
                                     std::string("\xff\xfe"), std::string(60'000, 'a')}) {
    statuses.push_back(Node(node_id));
  }
  statuses.push_back(Node("long-address"));
  statuses.back().address = std::string(60'000, '1');
  statuses.push_back(Node("address-of-control-characters"));
  statuses.back().address = "127.0.0.1:1\r\n\x1b[31m";
  statuses.push_back(Node("version-that-is-no-text"));
  statuses.back().server_version = "\xff";
  statuses.push_back(Node("workers-that-overflow"));
  statuses.back().worker_count = kMax;
  statuses.push_back(Node("rate-that-is-no-number"));
  statuses.back().steps_per_second = std::numeric_limits<double>::quiet_NaN();
  for (int32_t NodeStatus::*count : {&NodeStatus::environment_capacity, &NodeStatus::env_count,
                                     &NodeStatus::pool_count, &NodeStatus::worker_count}) {
    statuses.push_back(Node(absl::StrCat("negative-", statuses.size())));
    statuses.back().*count = -1;
  }
  return statuses;
}

TEST(HostilePeersTest, InvalidSamplesAreDropped) {
  const auto cluster = Join("a");
  const auto forger = Participant::Create(TestOptions("forger"), {});
  ASSERT_THAT(forger.status(), IsOk());
  std::vector<NodeStatus> forged = StatusesThatMakeNoSense();
  forged.push_back(Node("z"));
  NodeStatus own = Node("a");
  EXPECT_TRUE(Await([&] {
    for (const NodeStatus& status : forged) {
      EXPECT_THAT(Forge(**forger, status), IsOk());
    }
    ++own.pool_count;
    cluster->Publish(own);
    const auto nodes = cluster->Nodes();
    return !nodes.empty() && nodes.back().node_id == "z";
  }));
  EXPECT_THAT(IdsOf(*cluster), testing::ElementsAre("a", "z"));
}

TEST(HostilePeersTest, ForgedNodesAreBoundedAndLeaveWithTheForger) {
  const auto a = Join("a");
  const auto b = Join("b");
  ASSERT_TRUE(Await([&] { return a->Nodes().size() == 2; }));
  {
    const auto forger = Participant::Create(TestOptions("forger"), {});
    ASSERT_THAT(forger.status(), IsOk());
    int count = 0;
    NodeStatus own = Node("a");
    ASSERT_TRUE(Await([&] {
      for (int i = 0; i < 500; ++i) {
        Forge(**forger, Node(absl::StrCat("forged-", count++ % 6000))).IgnoreError();
      }
      ++own.pool_count;
      a->Publish(own);
      b->Publish(Node("b"));
      return a->Nodes().size() > 1000;
    }));
    EXPECT_LE(a->Nodes().size(), 4097);
  }
  a->Publish(Node("a"));
  b->Publish(Node("b"));
  EXPECT_TRUE(Await([&] { return a->Nodes().size() == 2; }));
  EXPECT_THAT(IdsOf(*a), testing::ElementsAre("a", "b"));
}

}  // namespace
}  // namespace procgen
