#ifndef TESTS_SERVICE_FLEET_FLEET_FIXTURE_H_
#define TESTS_SERVICE_FLEET_FLEET_FIXTURE_H_

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "gtest/gtest.h"
#include "server/fleet/fleet.h"
#include "server/rpc/server.h"
#include "tests/service/fleet/hostile_node.h"
#include "tests/service/scripted_learner.h"
#include "tests/service/server_process.h"
#include "tests/status_matchers.h"

namespace procgen {

inline constexpr int32_t kFleetNodeCapacity = 1000;

// The nodes that a cluster would report. Threads: any.
class NodeList {
 public:
  std::vector<NodeStatus> Nodes() const {
    absl::MutexLock lock(&mutex_);
    return nodes_;
  }
  void Set(const NodeStatus& status) {
    absl::MutexLock lock(&mutex_);
    for (NodeStatus& node : nodes_) {
      if (node.node_id == status.node_id) {
        node = status;
        return;
      }
    }
    nodes_.push_back(status);
  }
  void Remove(const std::string& node_id) {
    absl::MutexLock lock(&mutex_);
    nodes_.erase(std::remove_if(nodes_.begin(), nodes_.end(),
                                [&](const NodeStatus& node) { return node.node_id == node_id; }),
                 nodes_.end());
  }

 private:
  mutable absl::Mutex mutex_;
  std::vector<NodeStatus> nodes_;
};

// A fleet server in the test's process, and a single server for comparison.
class FleetTest : public testing::Test {
 protected:
  void SetUp() override { single_ = StartServer({}); }

  static std::unique_ptr<Server> StartServer(
      std::function<std::unique_ptr<PoolBackendFactory>(Metrics*)> make_backend_factory,
      const Limits& limits = {}) {
    ServerOptions options;
    options.limits = limits;
    options.address = "127.0.0.1:0";
    options.worker_count = 1;
    options.clone_source_allowlist = *CloneSourceAllowlist::Parse("local");
    options.make_backend_factory = std::move(make_backend_factory);
    return *Server::Start(options);
  }

  void StartNode(const std::string& node_id, const std::vector<std::string>& node_flags = {}) {
    std::vector<std::string> flags = {"--address=127.0.0.1:0", "--workers=1", "--log_level=error",
                                      "--drain_timeout=30s"};
    flags.insert(flags.end(), node_flags.begin(), node_flags.end());
    auto process = std::make_unique<ServerProcess>(flags);
    NodeStatus status;
    status.node_id = node_id;
    status.address = process->Address();
    status.environment_capacity = kFleetNodeCapacity;
    status.worker_count = 1;
    status.healthy = true;
    nodes_[node_id] = std::move(process);
    list_.Set(status);
  }

  // Starts a node behind a proxy, which damages its responses while Attack is on.
  HostileNode* StartHostileNode(const std::string& node_id, AnswerDamage damage) {
    StartNode(node_id);
    NodeStatus status = list_.Nodes().back();
    auto node = std::make_unique<HostileNode>(status.address, std::move(damage));
    status.address = node->address();
    list_.Set(status);
    return hostile_nodes_.emplace_back(std::move(node)).get();
  }

  void StartFleet(int64_t snapshot_requests = 50, const Limits& limits = {}) {
    const auto make_backend_factory = [&](Metrics* metrics) {
      FleetOptions options;
      options.nodes = [this] { return list_.Nodes(); };
      options.subscribe = [](absl::AnyInvocable<void()> /*changed*/) { return Subscription(); };
      options.snapshot_requests = snapshot_requests;
      options.log_bytes_max = log_bytes_max_;
      options.failover_timeout = failover_timeout_;
      options.poll_interval = poll_interval_;
      options.credentials = credentials_;
      if (adjust_ != nullptr) {
        adjust_(&options);
      }
      return std::make_unique<Fleet>(options, metrics);
    };
    server_ = StartServer(make_backend_factory, limits);
  }

  static std::unique_ptr<procgen_client::Client> Connect(const Server& server) {
    return Connect(server.address());
  }
  static std::unique_ptr<procgen_client::Client> Connect(const std::string& address) {
    return *procgen_client::Client::Connect(address);
  }

  // Executes the script on one server and on the fleet, and expects equal responses.
  void ExpectSameTrace(const LearnerScript& script, const std::function<void(int)>& faults) {
    const auto expected = PlayScript(script, Connect(*single_).get(), [](int) {});
    ASSERT_THAT(expected, IsOk());
    const auto actual = PlayScript(script, Connect(*server_).get(), faults);
    ASSERT_THAT(actual, IsOk());
    EXPECT_EQ(FirstDifference(*expected, *actual), -1);
  }

  static LearnerScript Script(int request_count = 400) {
    LearnerScript script;
    script.request_count = request_count;
    script.spec.add_games("coinrun");
    script.spec.add_games("maze");
    script.spec.add_games("bigfish");
    script.spec.set_env_count(24);
    script.spec.mutable_options()->set_rand_seed(3);
    script.spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
    return script;
  }

  std::string MetricsText() const { return server_->metrics().Text(); }

  int64_t log_bytes_max_ = FleetOptions().log_bytes_max;
  absl::Duration failover_timeout_ = absl::Seconds(20);
  absl::Duration poll_interval_ = absl::Seconds(1);
  FleetCredentials credentials_;
  std::function<void(FleetOptions*)> adjust_;
  NodeList list_;
  std::map<std::string, std::unique_ptr<ServerProcess>> nodes_;
  std::vector<std::unique_ptr<HostileNode>> hostile_nodes_;
  std::unique_ptr<Server> single_;
  std::unique_ptr<Server> server_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_FLEET_FLEET_FIXTURE_H_
