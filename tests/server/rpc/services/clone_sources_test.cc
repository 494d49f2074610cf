#include "server/rpc/services/clone_sources.h"

#include <string>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

bool Allows(const std::string& list, const std::string& address) {
  const absl::StatusOr<CloneSources> sources = CloneSources::Parse(list);
  EXPECT_THAT(sources, IsOk());
  return sources->Allows(*ParseAddress(address));
}

TEST(CloneSourcesTest, NoneIsNone) {
  for (const char* address : {"127.0.0.1:1", "unix:/x", "host:1"}) {
    EXPECT_FALSE(Allows("none", address));
    EXPECT_FALSE(CloneSources().Allows(*ParseAddress(address)));
  }
}

TEST(CloneSourcesTest, LocalIsThisMachine) {
  EXPECT_TRUE(Allows("local", "127.0.0.1:1"));
  EXPECT_TRUE(Allows("local", "unix:/x"));
  EXPECT_FALSE(Allows("local", "10.0.0.1:1"));
  EXPECT_FALSE(Allows("local", "127.0.0.1.example.com:1"));
}

TEST(CloneSourcesTest, AHostHasAnyPortAndAnAddressOne) {
  const std::string list = "Host.Example,other:7,[fd00::1]:8,unix:/run/x";
  EXPECT_TRUE(Allows(list, "host.example:1"));
  EXPECT_TRUE(Allows(list, "HOST.example:2"));
  EXPECT_TRUE(Allows(list, "Other:7"));
  EXPECT_TRUE(Allows(list, "[fd00::1]:8"));
  EXPECT_TRUE(Allows(list, "unix:/run/x"));
  EXPECT_FALSE(Allows(list, "other:8"));
  EXPECT_FALSE(Allows(list, "sub.host.example:1"));
  EXPECT_FALSE(Allows(list, "unix:/run/xy"));
  EXPECT_FALSE(Allows(list, "127.0.0.1:7"));
}

TEST(CloneSourcesTest, WhatIsNoSourceIsNamed) {
  for (const char* list : {"a b", "local,,", "*", "dns:///x:1", "local,http://x"}) {
    EXPECT_THAT(CloneSources::Parse(list),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: HOST, ")))
        << list;
  }
}

}  // namespace
}  // namespace procgen
