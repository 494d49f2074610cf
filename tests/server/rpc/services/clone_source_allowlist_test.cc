#include "server/rpc/services/clone_source_allowlist.h"

#include <string>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

bool Allows(const std::string& list, const std::string& address) {
  const absl::StatusOr<CloneSourceAllowlist> allowlist = CloneSourceAllowlist::Parse(list);
  EXPECT_THAT(allowlist, IsOk());
  return allowlist->Allows(*ParseAddress(address));
}

TEST(CloneSourceAllowlistTest, NoneAllowsNothing) {
  for (const char* address : {"127.0.0.1:1", "unix:/x", "host:1"}) {
    EXPECT_FALSE(Allows("none", address));
    EXPECT_FALSE(CloneSourceAllowlist().Allows(*ParseAddress(address)));
  }
}

TEST(CloneSourceAllowlistTest, LocalIsThisMachine) {
  EXPECT_TRUE(Allows("local", "127.0.0.1:1"));
  EXPECT_TRUE(Allows("local", "unix:/x"));
  EXPECT_FALSE(Allows("local", "10.0.0.1:1"));
  EXPECT_FALSE(Allows("local", "127.0.0.1.example.com:1"));
}

TEST(CloneSourceAllowlistTest, AHostHasAnyPortAndAnAddressOne) {
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

TEST(CloneSourceAllowlistTest, InvalidSourceIsNamed) {
  for (const char* list : {"a b", "local,,", "*", "dns:///x:1", "local,http://x"}) {
    EXPECT_THAT(CloneSourceAllowlist::Parse(list),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("list of HOST, ")))
        << list;
  }
}

}  // namespace
}  // namespace procgen
