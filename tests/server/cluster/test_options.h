#ifndef TESTS_SERVER_CLUSTER_TEST_OPTIONS_H_
#define TESTS_SERVER_CLUSTER_TEST_OPTIONS_H_

#include <unistd.h>

#include <string>

#include "absl/hash/hash.h"
#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "server/cluster/cluster.h"

namespace procgen {

// Options with a cluster name that no other test uses, and ports that few use.
inline ClusterOptions TestOptions(const std::string& node_id) {
  ClusterOptions options;
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  options.name = absl::StrCat("test-", getpid(), "-", absl::Hex(absl::HashOf(test)));
  options.domain_id = getpid() % 100;
  options.node_id = node_id;
  options.address = "127.0.0.1:50051";
  return options;
}

}  // namespace procgen

#endif  // TESTS_SERVER_CLUSTER_TEST_OPTIONS_H_
