#include "tests/service/fleet/test_fleet.h"

#include <unistd.h>

#include <csignal>
#include <utility>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// Concurrent tests use different domains where possible, and always different cluster names.
constexpr int32_t kDomainFirst = 100;
constexpr int32_t kDomainCount = 100;

}  // namespace

TestFleet::TestFleet(std::vector<std::string> fleet_flags)
    : fleet_flags_(std::move(fleet_flags)), domain_(kDomainFirst + getpid() % kDomainCount) {}

std::string TestFleet::ClusterName() { return absl::StrCat("test-", getpid()); }

std::vector<std::string> TestFleet::FlagsOf(const std::string& name) const {
  return {absl::StrCat("--cluster=", ClusterName()), absl::StrCat("--cluster_domain=", domain_),
          absl::StrCat("--node_id=", name), "--log_level=warning", "--drain_timeout=30s"};
}

void TestFleet::StartNode(const std::string& name, const std::vector<std::string>& node_flags) {
  std::vector<std::string> flags = FlagsOf(name);
  flags.insert(flags.end(), {"--address=127.0.0.1:0", "--workers=1"});
  flags.insert(flags.end(), node_flags.begin(), node_flags.end());
  auto process = std::make_unique<ServerProcess>(flags);
  EXPECT_NE(process->Address(), "") << process->beginning();
  nodes_[name] = std::move(process);
}

void TestFleet::KillNode(const std::string& name) { nodes_.erase(name); }

std::unique_ptr<ServerProcess> TestFleet::TakeNode(const std::string& name) {
  std::unique_ptr<ServerProcess> node = std::move(nodes_.at(name));
  nodes_.erase(name);
  return node;
}

void TestFleet::StartFleet(size_t node_count) {
  std::vector<std::string> flags = FlagsOf("fleet");
  flags.insert(flags.end(), {"--fleet", absl::StrCat("--address=", address_)});
  flags.insert(flags.end(), fleet_flags_.begin(), fleet_flags_.end());
  fleet_ = std::make_unique<ServerProcess>(flags);
  address_ = fleet_->Address();
  ASSERT_NE(address_, "") << fleet_->beginning();
  const auto client = Connect();
  const auto watch = client->WatchNodes();
  size_t seen = 0;
  while (seen < node_count + 1) {
    const auto nodes = watch->Next();
    ASSERT_THAT(nodes, IsOk());
    seen = static_cast<size_t>(nodes->nodes_size());
  }
  watch->Stop();
}

void TestFleet::KillFleet() { fleet_ = nullptr; }

void TestFleet::StopFleet() {
  fleet_->Signal(SIGTERM);
  EXPECT_EQ(fleet_->Wait(), 0);
  fleet_ = nullptr;
}

std::unique_ptr<procgen_client::Client> TestFleet::Connect() const {
  return procgen_client::Client::Connect(address_).value();
}

}  // namespace procgen
