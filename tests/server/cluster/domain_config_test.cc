#include "server/cluster/domain_config.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/cluster/cluster.h"

namespace procgen {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(DomainConfigTest, LocalNodesUseLoopback) {
  for (const char* address : {"127.0.0.1:1", "localhost:1", "unix:/x.sock", "[::1]:1"}) {
    EXPECT_EQ(InterfaceOf(address), "127.0.0.1") << address;
  }
  EXPECT_EQ(InterfaceOf("192.0.2.200:1"), "");  // not an address of this machine
  EXPECT_EQ(InterfaceOf("example.com:1"), "");
}

TEST(DomainConfigTest, HostsAreResolvedOrHaveNoAddress) {
  EXPECT_THAT(ResolveHost("localhost"), Contains("127.0.0.1"));
  EXPECT_THAT(ResolveHost("10.1.2.3"), Contains("10.1.2.3"));
  EXPECT_THAT(ResolveHost("no-such-host.invalid"), IsEmpty());
}

TEST(DomainConfigTest, NodesWithPeersSendNoMulticast) {
  ClusterOptions options;
  options.address = "example.com:1";
  EXPECT_THAT(DomainConfig(options, {}), HasSubstr("<AllowMulticast>spdp<"));
  options.peers = {"a"};
  EXPECT_THAT(DomainConfig(options, {}), HasSubstr("<AllowMulticast>false<"));
  EXPECT_THAT(DomainConfig(options, {"10.0.0.1"}), HasSubstr("<Peer address=\"10.0.0.1\"/>"));
  EXPECT_THAT(DomainConfig(options, {"10.0.0.1"}), Not(HasSubstr("NetworkInterface")));
}

TEST(DomainConfigTest, ManyPeersAreProbedLessOften) {
  ClusterOptions options;
  EXPECT_THAT(DomainConfig(options, {}), HasSubstr("<SPDPInterval>15000ms<"));
  options.peers = {"nodes"};
  for (const auto& [count, interval] :
       {std::pair<size_t, const char*>{1, "15000"}, {64, "128000"}, {10'000, "900000"}}) {
    const std::vector<std::string> addresses(count, "10.0.0.1");
    EXPECT_THAT(DomainConfig(options, addresses),
                HasSubstr(absl::StrCat("<SPDPInterval>", interval, "ms<")));
  }
}

}  // namespace
}  // namespace procgen
