#include "server/cluster/cluster_options.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

ClusterOptions GoodOptions() {
  ClusterOptions options;
  options.name = "night-runs_2.0";
  options.node_id = "node-0";
  options.address = "127.0.0.1:50051";
  return options;
}

std::string MessageOf(const ClusterOptions& options) {
  return std::string(CheckClusterOptions(options).message());
}

TEST(ClusterOptionsTest, NamesHaveNoWildcards) {
  for (const char* name : {"", "a*", "a b", "a/b", "a?", "\xc3\xa9"}) {
    ClusterOptions options = GoodOptions();
    options.name = name;
    EXPECT_THAT(MessageOf(options), HasSubstr("--cluster is '")) << name;
    options = GoodOptions();
    options.node_id = name;
    EXPECT_THAT(MessageOf(options), HasSubstr("--node_id is '")) << name;
  }
  ClusterOptions options = GoodOptions();
  options.name = std::string(kClusterNameLengthMax + 1, 'a');
  EXPECT_THAT(MessageOf(options), HasSubstr("1 to 64 letters"));
}

TEST(ClusterOptionsTest, DomainsHaveTheirRange) {
  for (const int32_t domain : {-1, kClusterDomainMax + 1}) {
    ClusterOptions options = GoodOptions();
    options.domain_id = domain;
    EXPECT_THAT(MessageOf(options), HasSubstr("allowed: 0 to 230"));
  }
}

TEST(ClusterOptionsTest, PeersAreHosts) {
  for (const char* peer : {"", "host:7400", "<Peer/>", "a b"}) {
    ClusterOptions options = GoodOptions();
    options.peers = {"10.0.0.1", peer};
    EXPECT_THAT(MessageOf(options), HasSubstr("--cluster_peers has '")) << peer;
  }
}

}  // namespace
}  // namespace procgen
