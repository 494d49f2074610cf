// Hostile peers: a participant that forges nodes with well-formed samples, and invalid packets.
// Every process that reaches the ports of a domain can write to it.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/cluster/cluster.h"
#include "server/cluster/participant.h"
#include "server/concurrency/steady_time.h"
#include "tests/server/cluster/cluster_watch.h"
#include "tests/server/cluster/publisher.h"
#include "tests/server/cluster/test_options.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::Contains;
using ::testing::Field;

// Publishes this status, as a participant may do of any node.
absl::Status Forge(const Participant& forger, const NodeStatus& status) {
  return forger.Write({.status = status, .incarnation = 1, .losses = {}});
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

bool Lists(const Cluster& cluster, const std::string& node_id) {
  const std::vector<std::string> ids = IdsOf(cluster);
  return std::find(ids.begin(), ids.end(), node_id) != ids.end();
}

// Returns the incarnation that a participant reads; 0: it reads no such node.
int64_t IncarnationOf(const std::string& node_id, Participant& participant) {
  const std::vector<NodeReport> reports = participant.ReadNodes();
  const auto report = std::find_if(reports.begin(), reports.end(), [&](const NodeReport& each) {
    return each.status.node_id == node_id;
  });
  return report == reports.end() ? 0 : report->incarnation;
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
  for (const NodeStatus& status : StatusesThatMakeNoSense()) {
    ASSERT_THAT(Forge(**forger, status), IsOk());
  }
  for (const NodeLoss& loss :
       {NodeLoss{"two words", 1}, NodeLoss{"a", -1}, NodeLoss{"a", kIncarnationMax + 1}}) {
    ASSERT_THAT((*forger)->Write({Node("losses-that-make-no-sense"), 1, {loss}}), IsOk());
  }
  ASSERT_THAT(Forge(**forger, Node("z")), IsOk());
  EXPECT_TRUE(ClusterWatch(cluster.get()).Await([&] {
    const auto nodes = cluster->Nodes();
    return !nodes.empty() && nodes.back().node_id == "z";
  }));
  EXPECT_THAT(IdsOf(*cluster), testing::ElementsAre("a", "z"));
}

TEST(HostilePeersTest, ForgedNodesAreBoundedAndLeaveWithTheForger) {
  const auto a = Join("a");
  const auto b = Join("b");
  ASSERT_TRUE(ClusterWatch(a.get()).Await([&] { return a->Nodes().size() == 2; }));
  {
    const auto forger = Participant::Create(TestOptions("forger"), {});
    ASSERT_THAT(forger.status(), IsOk());
    for (int i = 0; i < 6000; ++i) {
      Forge(**forger, Node(absl::StrCat("forged-", i))).IgnoreError();
      if (i % 1000 == 0) {
        a->Publish(Node("a"));
        b->Publish(Node("b"));
      }
    }
    ASSERT_TRUE(ClusterWatch(a.get()).Await([&] { return a->Nodes().size() > 1000; }));
    EXPECT_LE(a->Nodes().size(), 4097);
  }
  a->Publish(Node("a"));
  b->Publish(Node("b"));
  EXPECT_TRUE(ClusterWatch(a.get()).Await([&] { return a->Nodes().size() == 2; }));
  EXPECT_THAT(IdsOf(*a), testing::ElementsAre("a", "b"));
}

TEST(HostilePeersTest, ForgedNodeWithoutHeartbeatsDisappears) {
  const auto cluster = Join("a");
  const Publisher publisher(cluster.get(), Node("a"));
  const auto forger = Participant::Create(TestOptions("forger"), {});
  ASSERT_THAT(forger.status(), IsOk());
  ASSERT_THAT(Forge(**forger, Node("z")), IsOk());
  ASSERT_TRUE(ClusterWatch(cluster.get()).Await([&] { return cluster->Nodes().size() == 2; }));
  EXPECT_TRUE(ClusterWatch(cluster.get()).Await([&] { return cluster->Nodes().size() == 1; }));
}

TEST(HostilePeersTest, ForgedLossIsRefuted) {
  const auto a = Join("a");
  const auto b = Join("b");
  const Publisher publisher_a(a.get(), Node("a"));
  const Publisher publisher_b(b.get(), Node("b"));
  ClusterWatch watch(a.get());
  ASSERT_TRUE(watch.Await([&] { return a->Nodes().size() == 2; }));
  const auto forger = Participant::Create(TestOptions("forger"), {});
  ASSERT_THAT(forger.status(), IsOk());
  for (const int64_t incarnation : {int64_t{1}, int64_t{100}, kIncarnationMax}) {
    ASSERT_THAT((*forger)->Write({Node("z"), 1, {{"b", incarnation}}}), IsOk());
    const absl::Time end = SteadyNow() + absl::Seconds(20);
    while (IncarnationOf("b", **forger) <= incarnation && SteadyNow() < end) {
      (*forger)->Wait(kRefreshInterval);
    }
    EXPECT_EQ(IncarnationOf("b", **forger), incarnation + 1);
    EXPECT_TRUE(watch.Await([&] { return Lists(*a, "b"); }));
  }
}

TEST(HostilePeersTest, DuplicateNodeIdDoesNotReplaceTheLocalNode) {
  const auto cluster = Join("a");
  const auto forger = Participant::Create(TestOptions("forger"), {});
  ASSERT_THAT(forger.status(), IsOk());
  NodeStatus copy = Node("a");
  copy.address = "192.0.2.1:50051";
  ASSERT_THAT(Forge(**forger, copy), IsOk());
  ASSERT_THAT(Forge(**forger, Node("z")), IsOk());
  ASSERT_TRUE(ClusterWatch(cluster.get()).Await([&] { return cluster->Nodes().size() == 2; }));
  EXPECT_THAT(cluster->Nodes(), Contains(Field(&NodeStatus::address, "127.0.0.1:1")).Times(2));
}

// A UDP socket on loopback. RTPS ports for discovery are 7400 + 250 * domain + 10 + 2 *
// participant; user data uses the next port.
class Socket {
 public:
  explicit Socket(uint16_t port) : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const sockaddr_in address = AddressOf(port);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const timeval timeout = {.tv_sec = 20, .tv_usec = 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  }
  ~Socket() { close(socket_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  std::string Receive() const {
    std::string packet(65'536, '\0');
    const ssize_t bytes = recv(socket_, packet.data(), packet.size(), 0);
    packet.resize(bytes > 0 ? static_cast<size_t>(bytes) : 0);
    return packet;
  }
  void Send(const std::string& packet, uint16_t port) const {
    const sockaddr_in address = AddressOf(port);
    sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&address),
           sizeof address);
  }

 private:
  static sockaddr_in AddressOf(uint16_t port) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  const int socket_;
};

std::string Mutated(std::string packet, std::minstd_rand* random) {
  const auto draw = [random](size_t end) { return static_cast<size_t>((*random)()) % end; };
  for (size_t i = draw(8); i > 0 && !packet.empty(); --i) {
    packet[draw(packet.size())] = static_cast<char>(draw(256));
  }
  switch (draw(4)) {
    case 0:
      packet.resize(draw(packet.size() + 1));
      break;
    case 1:
      packet.append(draw(200), static_cast<char>(draw(256)));
      break;
    default:
      break;
  }
  return packet;
}

TEST(HostilePeersTest, InvalidPacketsDoNotChangeTheCluster) {
  constexpr int kParticipantOfTheSocket = kNodesOfPeerMax - 1;
  ClusterOptions options = TestOptions("a");
  options.peers = {"127.0.0.1"};
  const int first_port = 7400 + 250 * options.domain_id + 10;
  auto joined = Cluster::Join(options);
  ASSERT_THAT(joined, IsOk());
  const auto a = *std::move(joined);
  const Socket socket(static_cast<uint16_t>(first_port + 2 * kParticipantOfTheSocket));
  const std::string packet = socket.Receive();  // a discovery packet of a node
  ASSERT_GT(packet.size(), 100U);
  ASSERT_EQ(packet.substr(0, 4), "RTPS");
  std::minstd_rand random(7);  // NOLINT(cert-msc*): a fixed seed
  for (int i = 0; i < 20'000; ++i) {
    const std::string header = packet.substr(0, 20);
    const std::string sent = i % 10 == 0   ? Mutated(std::string(200, '\x5a'), &random)
                             : i % 10 == 1 ? header + Mutated(packet.substr(20, 60), &random)
                                           : Mutated(packet, &random);
    socket.Send(sent, static_cast<uint16_t>(first_port + static_cast<int>(random() % 8)));
  }
  a->Publish(Node("a"));
  const auto b = Join("b");
  EXPECT_TRUE(ClusterWatch(a.get()).Await([&] { return a->Nodes().size() == 2; }));
  EXPECT_TRUE(ClusterWatch(b.get()).Await([&] { return b->Nodes().size() == 2; }));
  EXPECT_THAT(IdsOf(*a), testing::ElementsAre("a", "b"));
}

}  // namespace
}  // namespace procgen
