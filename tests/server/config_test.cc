#include "server/config.h"

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

TEST(ConfigTest, DefaultsAreValid) { EXPECT_THAT(CheckConfig(Config()), IsOk()); }

TEST(ConfigTest, AddressWithoutPortIsRefused) {
  Config config;
  config.server.address = "localhost";
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--address is 'localhost', allowed: 'HOST:PORT' with a port of 0 to 65535, "
                       "or 'unix:PATH'"));
}

TEST(ConfigTest, PortOutOfRangeIsRefused) {
  Config config;
  config.server.address = "127.0.0.1:65536";
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("127.0.0.1:65536")));
}

TEST(ConfigTest, UnixSocketIsAllowed) {
  Config config;
  config.server.address = "unix:/tmp/procgen.sock";
  EXPECT_THAT(CheckConfig(config), IsOk());
}

TEST(ConfigTest, LimitOutOfRangeIsRefusedByName) {
  Config config;
  config.server.limits.request_bytes_max = 1000;
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--request_bytes_max is 1000, allowed: 65536 to 2147483647"));
  config.server.limits = {};
  config.server.limits.observation_bytes_max = 0;
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--observation_bytes_max is 0, allowed: 65536 to 1099511627776"));
}

TEST(ConfigTest, PoolLargerThanServerIsRefused) {
  Config config;
  config.server.limits.pool_environment_count_max = 11;
  config.server.limits.environment_count_max = 10;
  EXPECT_THAT(CheckConfig(config), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("--pool_environment_count_max is 11")));
}

}  // namespace
}  // namespace procgen
