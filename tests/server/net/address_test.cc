#include "server/net/address.h"

#include <string>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

bool IsLocalText(const std::string& text) {
  const absl::StatusOr<Address> address = ParseAddress(text);
  return address.ok() && IsLocal(*address);
}

TEST(AddressTest, HostsAndSocketsAreParsed) {
  EXPECT_EQ(ParseAddress("example.com:1")->host, "example.com");
  EXPECT_EQ(ParseAddress("example.com:65535")->port, 65535);
  EXPECT_EQ(ParseAddress("[::1]:50051")->host, "::1");
  EXPECT_EQ(ParseAddress("unix:/run/x.sock")->unix_path, "/run/x.sock");
}

TEST(AddressTest, AmbiguousGrpcAddressesAreRejected) {
  for (const char* text :
       {"", ":1", "host", "host:", "host:65536", "host:-1", "unix:", "[host]:1", "[::1:1", "::1:1",
        "dns:///host:1", "dns://8.8.8.8/host:1", "ipv4:127.0.0.1:1", "ipv4:127.0.0.1:1,10.0.0.1:1",
        "xds:///host:1", "unix-abstract:x:1", "a b:1", "a/b:1", "user@host:1"}) {
    EXPECT_FALSE(ParseAddress(text).ok()) << text;
  }
}

TEST(AddressTest, WildcardsCannotBeConnectedTo) {
  for (const char* text : {"0.0.0.0:1", "[::]:1", "[0::0]:1"}) {
    EXPECT_TRUE(IsWildcard(*ParseAddress(text))) << text;
  }
  for (const char* text : {"127.0.0.1:1", "0.0.0.1:1", "[::1]:1", "host:0", "unix:x"}) {
    EXPECT_FALSE(IsWildcard(*ParseAddress(text))) << text;
  }
}

TEST(AddressTest, OnlyThisMachineIsLocal) {
  for (const char* text :
       {"127.0.0.1:1", "127.255.0.9:1", "localhost:1", "LocalHost:1", "[::1]:1", "unix:x"}) {
    EXPECT_TRUE(IsLocalText(text)) << text;
  }
  for (const char* text :
       {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "127.0.0.1.example.com:1", "127.1:1",
        "localhost.example.com:1", "[::ffff:127.0.0.1]:1", "[fe80::1]:1"}) {
    EXPECT_FALSE(IsLocalText(text)) << text;
  }
}

TEST(AddressTest, TargetsNameTheirScheme) {
  EXPECT_EQ(GrpcTargetOf(*ParseAddress("unix:/x")), "unix:/x");
  EXPECT_EQ(GrpcTargetOf(*ParseAddress("host:1")), "dns:///host:1");
  EXPECT_EQ(GrpcTargetOf(*ParseAddress("[::1]:1")), "dns:///[::1]:1");
}

}  // namespace
}  // namespace procgen
