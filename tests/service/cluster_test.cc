// Cluster discovery: server processes, observed over gRPC.

#include <unistd.h>

#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/hash/hash.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using procgen_client::Client;
using testing::ElementsAre;

// For changes that do not wait for a lease to expire.
constexpr absl::Duration kGoneAtOnceWithin = absl::Seconds(1);
constexpr absl::Duration kSeenWithin = absl::Seconds(20);

// A server process that is a node of the test's cluster, and a client of it.
class Node {
 public:
  Node(const std::string& node_id, const std::string& cluster,
       const std::vector<std::string>& flags = {})
      : process_(FlagsOf(node_id, cluster, flags)), address_(process_.Address()) {
    absl::StatusOr<std::unique_ptr<Client>> client = Client::Connect(address_);
    EXPECT_THAT(client, IsOk()) << process_.beginning();
    client_ = *std::move(client);
  }

  ServerProcess& process() { return process_; }
  const std::string& address() const { return address_; }
  Client& client() { return *client_; }
  std::shared_ptr<grpc::Channel> Channel() const { return ChannelTo(address_); }

  // The ids of the nodes that this node lists.
  std::vector<std::string> Listed() {
    const auto nodes = client_->ListNodes();
    EXPECT_THAT(nodes, IsOk());
    return nodes.ok() ? IdsOf(*nodes) : std::vector<std::string>();
  }

  // Waits for a list that satisfies `is_expected`; returns false after `timeout`.
  bool WaitForNodes(const std::function<bool(const v1::ListNodesResponse&)>& is_expected,
                    absl::Duration timeout = kSeenWithin) {
    const absl::Time end = absl::Now() + timeout;
    while (absl::Now() < end) {
      const auto nodes = client_->ListNodes();
      EXPECT_THAT(nodes, IsOk());
      if (!nodes.ok() || is_expected(*nodes)) {
        return nodes.ok();
      }
      absl::SleepFor(absl::Milliseconds(5));
    }
    return false;
  }

  bool WaitForIds(const std::vector<std::string>& ids, absl::Duration timeout = kSeenWithin) {
    return WaitForNodes([&](const v1::ListNodesResponse& nodes) { return IdsOf(nodes) == ids; },
                        timeout);
  }

 private:
  static std::vector<std::string> FlagsOf(const std::string& node_id, const std::string& cluster,
                                          const std::vector<std::string>& flags) {
    std::vector<std::string> all = {"--address=127.0.0.1:0", "--workers=1", "--node_id=" + node_id,
                                    "--cluster=" + cluster,
                                    absl::StrCat("--cluster_domain=", getpid() % 100)};
    all.insert(all.end(), flags.begin(), flags.end());
    return all;
  }

  static std::vector<std::string> IdsOf(const v1::ListNodesResponse& nodes) {
    std::vector<std::string> ids;
    for (const v1::Node& node : nodes.nodes()) {
      ids.push_back(node.name().substr(std::string("nodes/").size()));
    }
    return ids;
  }

  ServerProcess process_;
  const std::string address_;
  std::unique_ptr<Client> client_;
};

class ClusterServiceTest : public testing::Test {
 protected:
  // Unique to this test and process.
  const std::string cluster_ = absl::StrCat(
      "test-", getpid(), "-",
      absl::Hex(absl::HashOf(
          std::string(testing::UnitTest::GetInstance()->current_test_info()->name()))));
};

TEST_F(ClusterServiceTest, ThreeServersListEachOther) {
  Node a("a", cluster_);
  Node b("b", cluster_);
  Node c("c", cluster_);
  PoolStream run(b.Channel());
  ASSERT_THAT(run.Start(MazeSpec(7)), IsOk());
  for (Node* node : {&a, &b, &c}) {
    EXPECT_TRUE(node->WaitForIds({"a", "b", "c"}));
    EXPECT_THAT(node->Listed(), ElementsAre("a", "b", "c"));
    const auto nodes = node->client().ListNodes();
    EXPECT_EQ(nodes->cluster(), cluster_);
    EXPECT_EQ(nodes->nodes(1).address(), b.address());
    EXPECT_TRUE(nodes->nodes(1).healthy());
    EXPECT_FALSE(nodes->nodes(1).draining());
    EXPECT_TRUE(node->WaitForNodes([](const v1::ListNodesResponse& response) {
      return response.nodes_size() == 3 && response.nodes(1).env_count() == 7 &&
             response.nodes(1).pool_count() == 1;
    }));
  }
  EXPECT_EQ(a.client().ListNodes()->local_node(), "nodes/a");
}

TEST_F(ClusterServiceTest, StoppingServerReportsDrainAndDisappears) {
  Node a("a", cluster_);
  Node b("b", cluster_);
  ASSERT_TRUE(a.WaitForIds({"a", "b"}));
  // The drain waits a second for the responses, which are not read.
  PoolStream run(b.Channel());
  ASSERT_THAT(run.Start(MazeSpec(1000)), IsOk());
  for (int i = 0; i < 3; ++i) {
    run.Write(SliceStepRequest(0, 1000, 4));
  }
  while (b.client().GetPool(run.name())->step_count() < 2000) {
  }
  b.process().Signal(SIGTERM);
  EXPECT_TRUE(a.WaitForNodes([](const v1::ListNodesResponse& nodes) {
    return nodes.nodes_size() == 2 && nodes.nodes(1).draining() && !nodes.nodes(1).healthy();
  }));
  EXPECT_EQ(b.process().Wait(), 0);
  EXPECT_TRUE(a.WaitForIds({"a"}, kGoneAtOnceWithin));
}

TEST_F(ClusterServiceTest, AdvertisedAddressIsReported) {
  Node a("a", cluster_, {"--advertised_address=localhost:0"});
  const std::string port = a.address().substr(a.address().rfind(':'));
  EXPECT_EQ(a.client().ListNodes()->nodes(0).address(), "localhost" + port);
}

}  // namespace
}  // namespace procgen
