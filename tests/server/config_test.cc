#include "server/config.h"

#include <functional>
#include <string>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;

struct Rejected {
  std::string message;
  std::function<void(Config*)> set;
};

TEST(ConfigTest, ValuesThatAreNotAllowedAreRejectedByName) {
  const Rejected all[] = {
      {"--address is 'localhost', allowed: 'HOST:PORT' with a port of 0 to 65535, or 'unix:PATH'",
       [](Config* config) { config->server.address = "localhost"; }},
      {"--address is no..host:50051: host 'no..host' cannot be resolved",
       [](Config* config) { config->server.address = "no..host:50051"; }},
      {"--tls_key is missing", [](Config* config) { config->tls.certificate = "certificate.pem"; }},
      {"--tls_certificate is missing", [](Config* config) { config->tls.key = "key.pem"; }},
      {"--tls_client_ca is given without",
       [](Config* config) { config->tls.client_ca = "ca.pem"; }},
      {"--request_bytes_max is 1000, allowed: 65536 to 2147483647",
       [](Config* config) { config->server.limits.request_bytes_max = 1000; }},
      {"--owner_bytes_max is 0, allowed: 65536 to 1099511627776",
       [](Config* config) { config->server.limits.owner_bytes_max = 0; }},
      {"--episode_history_bytes_max is -1, allowed: 0 to 1099511627776",
       [](Config* config) { config->server.limits.episode_history_bytes_max = -1; }},
      {"--keepalive_time in milliseconds is 99, allowed: 100 to 86400000",
       [](Config* config) { config->server.keepalive_time = absl::Milliseconds(99); }},
      {"--keepalive_timeout in milliseconds is 90000000, allowed: 100 to 86400000",
       [](Config* config) { config->server.keepalive_timeout = absl::Hours(25); }},
      {"--cluster is missing", [](Config* config) { config->cluster.peers = {"a"}; }},
      {"--node_id is 'a b'", [](Config* config) { config->cluster.node_id = "a b"; }},
      {"--cluster is 'a*'", [](Config* config) { config->cluster.name = "a*"; }},
  };
  for (const Rejected& rejected : all) {
    Config config;
    EXPECT_THAT(CheckConfig(config), IsOk());
    rejected.set(&config);
    EXPECT_THAT(CheckConfig(config),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(rejected.message)));
  }
}

TEST(ConfigTest, RemoteListeningNeedsTlsAndAuthentication) {
  Config config;
  config.server.address = "0.0.0.0:50051";
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--address is 0.0.0.0:50051, which other machines can reach, without TLS: "
                       "give --tls_certificate and --tls_key; and without authentication: give "
                       "--tokens or --tls_client_ca; or listen on loopback or a unix socket; or "
                       "--allow_insecure"));
  config.tls = {"certificate.pem", "key.pem", ""};
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("give --tokens or")));
  config.tokens = "tokens";
  EXPECT_THAT(CheckConfig(config), IsOk());
  config.tokens = "";
  config.tls.client_ca = "ca.pem";
  EXPECT_THAT(CheckConfig(config), IsOk());
  config.tls = {};
  config.tokens = "tokens";
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("without TLS: give")));
  config.allow_insecure = true;
  EXPECT_THAT(CheckConfig(config), IsOk());
}

TEST(ConfigTest, MetricsAreLocalByDefault) {
  Config config;
  for (const char* address : {"127.0.0.1:9090", "localhost:0"}) {
    config.metrics_address = address;
    EXPECT_THAT(CheckConfig(config), IsOk());
  }
  config.metrics_address = "0.0.0.0:9090";
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--metrics_address is 0.0.0.0:9090, which other machines can reach, without "
                       "TLS and authentication: listen on loopback; or --allow_insecure"));
  config.allow_insecure = true;
  EXPECT_THAT(CheckConfig(config), IsOk());
}

TEST(ConfigTest, InvalidMetricsAddressIsRejected) {
  for (const char* address : {"9090", "localhost", "127.0.0.1:80s", "unix:/tmp/metrics.sock",
                              "127.0.0.1:1,0.0.0.0:2", "[::1]:9090"}) {
    Config config;
    config.metrics_address = address;
    EXPECT_THAT(CheckConfig(config),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr("', allowed: 'HOST:PORT' with a name or an IPv4 address")));
  }
}

TEST(ConfigTest, RemotePagesNeedTlsAndTokens) {
  Config config;
  config.web_address = "127.0.0.1:8080";
  EXPECT_THAT(CheckConfig(config), IsOk());
  config.web_address = "[::]:8080";
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "--web_address is [::]:8080, which other machines can reach, without TLS: "
                       "give --tls_certificate and --tls_key; and without authentication: give "
                       "--tokens; or listen on loopback; or --allow_insecure"));
  config.tls = {"certificate.pem", "key.pem", ""};
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("without authentication")));
  config.tokens = "tokens";
  EXPECT_THAT(CheckConfig(config), IsOk());
  config.tls = {};
  config.tokens = "";
  config.allow_insecure = true;
  EXPECT_THAT(CheckConfig(config), IsOk());
}

TEST(ConfigTest, PagesNeedTokensDespiteClientCertificates) {
  Config config;
  config.web_address = "127.0.0.1:8080";
  config.tls = {"certificate.pem", "key.pem", "ca.pem"};
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("give --tokens as well")));
  config.tokens = "tokens";
  EXPECT_THAT(CheckConfig(config), IsOk());
}

TEST(ConfigTest, InvalidPageAddressesAndHostsAreRejected) {
  for (const char* address : {"8080", "localhost", "127.0.0.1:80s", "unix:/tmp/web.sock"}) {
    Config config;
    config.web_address = address;
    EXPECT_THAT(CheckConfig(config),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: 'HOST:PORT'")));
  }
  for (const char* host : {"", "lab.example:80", "http://lab.example", "*"}) {
    Config config;
    config.web_address = "127.0.0.1:0";
    config.web_allowed_hosts = {"good.example", host};
    EXPECT_THAT(CheckConfig(config), StatusIs(absl::StatusCode::kInvalidArgument,
                                              HasSubstr("--web_allowed_hosts has '")))
        << host;
  }
  Config config;
  config.web_allowed_hosts = {"lab.example"};
  EXPECT_THAT(CheckConfig(config),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("without --web_address")));
}

TEST(ConfigTest, ClusterNodesNeedAReachableAddress) {
  Config config;
  config.cluster.name = "c";
  EXPECT_THAT(CheckConfig(config), IsOk());
  config.allow_insecure = true;
  for (const char* wildcard : {"0.0.0.0:50051", "[::]:50051"}) {
    config.server.address = wildcard;
    config.server.advertised_address = "";
    EXPECT_THAT(CheckConfig(config), StatusIs(absl::StatusCode::kInvalidArgument,
                                              HasSubstr("give --advertised_address=HOST:PORT")));
    config.server.advertised_address = "node-0.nodes:0";
    EXPECT_THAT(CheckConfig(config), IsOk());
  }
  for (const char* wrong : {"0.0.0.0:1", "host", "dns:///host:1"}) {
    config.server.advertised_address = wrong;
    EXPECT_THAT(CheckConfig(config),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--advertised_address is")));
  }
}

}  // namespace
}  // namespace procgen
