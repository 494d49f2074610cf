#include "server/config.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/cluster/cluster.h"
#include "server/net/address.h"

namespace procgen {
namespace {

constexpr int64_t kKeepaliveMsMax = 24 * 3600 * 1000;

struct Range {
  absl::string_view flag;
  int64_t value;
  int64_t min;
  int64_t max;
};

absl::Status CheckAddress(const Config& config) {
  const std::string& address = config.server.address;
  if (!ParseAddress(address).ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--address is '", address,
                     "', allowed: 'HOST:PORT' with a port of 0 to 65535, or 'unix:PATH'"));
  }
  return absl::OkStatus();
}

bool OthersCanReach(const Config& config) {
  const absl::StatusOr<Address> address = ParseAddress(config.server.address);
  return !address.ok() || !IsLocal(*address);
}

// The error of an address that strangers can reach. `credentials`: flags; `elsewhere`: safe places.
absl::Status ReachableError(absl::string_view flag, absl::string_view address, bool has_tls,
                            bool has_authentication, absl::string_view credentials,
                            absl::string_view elsewhere) {
  return absl::InvalidArgumentError(absl::StrCat(
      "--", flag, " is ", address, ", which other machines can reach, ",
      has_tls ? "" : "without TLS: give --tls_certificate and --tls_key",
      has_tls || has_authentication ? "" : "; and ",
      has_authentication ? "" : absl::StrCat("without authentication: give ", credentials),
      "; or listen on ", elsewhere, "; or --allow_insecure"));
}

absl::Status CheckAccess(const Config& config) {
  const TlsPaths& tls = config.tls;
  if (tls.certificate.empty() != tls.key.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--tls_", tls.key.empty() ? "key" : "certificate",
                     " is missing, allowed: ", "--tls_certificate and --tls_key, or none of them"));
  }
  if (!tls.client_ca.empty() && tls.certificate.empty()) {
    return absl::InvalidArgumentError(
        "--tls_client_ca is given without --tls_certificate and --tls_key, which it needs");
  }
  const bool has_tls = !tls.certificate.empty();
  const bool has_authentication = !tls.client_ca.empty() || !config.tokens.empty();
  if (OthersCanReach(config) && !config.allow_insecure && (!has_tls || !has_authentication)) {
    if (absl::Status status = CheckResolvable(*ParseAddress(config.server.address)); !status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--address is ", config.server.address, ": ", status.message()));
    }
    return ReachableError("address", config.server.address, has_tls, has_authentication,
                          "--tokens or --tls_client_ca", "loopback or a unix socket");
  }
  return absl::OkStatus();
}

absl::Status CheckMetricsAddress(const Config& config) {
  const std::string& given = config.metrics_address;
  if (given.empty()) {
    return absl::OkStatus();
  }
  const absl::StatusOr<Address> address = ParseAddress(given);
  // Debian builds the library of the page without IPv6.
  if (!address.ok() || address->host.empty() || absl::StrContains(address->host, ':')) {
    return absl::InvalidArgumentError(
        absl::StrCat("--metrics_address is '", given,
                     "', allowed: 'HOST:PORT' with a name or an IPv4 address and a port of 0 to "
                     "65535, or nothing"));
  }
  if (!IsLocal(*address) && !config.allow_insecure) {
    return absl::InvalidArgumentError(
        absl::StrCat("--metrics_address is ", given,
                     ", which other machines can reach, without TLS and authentication: listen on "
                     "loopback; or --allow_insecure"));
  }
  return absl::OkStatus();
}

absl::Status CheckWebAllowedHosts(const Config& config) {
  for (const std::string& host : config.web_allowed_hosts) {
    const absl::StatusOr<Address> address = ParseAddress(absl::StrCat(host, ":0"));
    if (!address.ok() || address->host != host) {
      return absl::InvalidArgumentError(absl::StrCat("--web_allowed_hosts has '", host,
                                                     "', allowed: names of hosts, without ports"));
    }
  }
  if (config.web_address.empty() && !config.web_allowed_hosts.empty()) {
    return absl::InvalidArgumentError("--web_allowed_hosts is given without --web_address");
  }
  return absl::OkStatus();
}

// As CheckAccess, for pages.
absl::Status CheckWebAccess(const Config& config, const Address& address) {
  const bool has_tls = !config.tls.certificate.empty();
  const bool has_tokens = !config.tokens.empty();
  if (!config.tls.client_ca.empty() && !has_tokens) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--web_address is ", config.web_address,
        " with --tls_client_ca and without --tokens, but the pages call the server from "
        "within and present no certificate: give --tokens as well"));
  }
  if (!IsLocal(address) && !config.allow_insecure && (!has_tls || !has_tokens)) {
    return ReachableError("web_address", config.web_address, has_tls, has_tokens, "--tokens",
                          "loopback");
  }
  return absl::OkStatus();
}

absl::Status CheckWeb(const Config& config) {
  if (absl::Status status = CheckWebAllowedHosts(config); !status.ok()) {
    return status;
  }
  if (config.web_address.empty()) {
    return absl::OkStatus();
  }
  const absl::StatusOr<Address> address = ParseAddress(config.web_address);
  if (!address.ok() || address->host.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--web_address is '", config.web_address,
                     "', allowed: 'HOST:PORT' with a port of 0 to 65535, or nothing"));
  }
  return CheckWebAccess(config, *address);
}

absl::Status CheckAdvertisedAddress(const Config& config) {
  const std::string& given = config.server.advertised_address;
  if (!given.empty()) {
    const absl::StatusOr<Address> address = ParseAddress(given);
    if (!address.ok() || IsWildcard(*address)) {
      return absl::InvalidArgumentError(
          absl::StrCat("--advertised_address is '", given,
                       "', allowed: 'HOST:PORT' with a host that others can reach and a port of 0 "
                       "to 65535, 'unix:PATH', or nothing"));
    }
    return absl::OkStatus();
  }
  const absl::StatusOr<Address> address = ParseAddress(config.server.address);
  if (!config.cluster.name.empty() && address.ok() && IsWildcard(*address)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--address is ", config.server.address,
                     ", to which the other nodes of --cluster cannot connect: give "
                     "--advertised_address=HOST:PORT"));
  }
  return absl::OkStatus();
}

absl::Status CheckCluster(const Config& config) {
  const ClusterOptions& cluster = config.cluster;
  if (absl::Status status = CheckAdvertisedAddress(config); !status.ok()) {
    return status;
  }
  if (!cluster.name.empty()) {
    return CheckClusterOptions(cluster);
  }
  if (cluster.domain_id != 0 || !cluster.peers.empty()) {
    return absl::InvalidArgumentError(
        "--cluster is missing, which the other flags that begin with --cluster_ need");
  }
  return CheckNodeId(cluster.node_id);
}

std::vector<Range> RangesOf(const Limits& limits) {
#define PROCGEN_RANGE(name, value, least, most, what) {#name, limits.name, least, most},
  return {PROCGEN_LIMITS(PROCGEN_RANGE)};
#undef PROCGEN_RANGE
}

absl::Status CheckRanges(const Config& config) {
  std::vector<Range> ranges = RangesOf(config.server.limits);
  ranges.push_back({"workers", config.server.worker_count, 1, 1024});
  ranges.push_back({"keepalive_time in milliseconds",
                    absl::ToInt64Milliseconds(config.server.keepalive_time), 100, kKeepaliveMsMax});
  ranges.push_back({"keepalive_timeout in milliseconds",
                    absl::ToInt64Milliseconds(config.server.keepalive_timeout), 100,
                    kKeepaliveMsMax});
  ranges.push_back({"web_viewers_max", config.web_viewers_max, 1, 1024});
  for (const Range& range : ranges) {
    if (range.value < range.min || range.value > range.max) {
      return absl::InvalidArgumentError(absl::StrCat("--", range.flag, " is ", range.value,
                                                     ", allowed: ", range.min, " to ", range.max));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckConfig(const Config& config) {
  for (const auto check :
       {CheckAddress, CheckMetricsAddress, CheckCluster, CheckRanges, CheckAccess, CheckWeb}) {
    if (absl::Status status = check(config); !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

absl::Status LoadSecrets(Config* config) {
  if (!config->tls.certificate.empty()) {
    absl::StatusOr<std::shared_ptr<TlsFiles>> tls = TlsFiles::Open(config->tls);
    if (!tls.ok()) {
      return tls.status();
    }
    config->server.tls = *std::move(tls);
  }
  if (!config->tokens.empty()) {
    absl::StatusOr<std::shared_ptr<TokenFile>> tokens = TokenFile::Open(config->tokens);
    if (!tokens.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("--tokens: ", tokens.status().message()));
    }
    config->server.tokens = *std::move(tokens);
  }
  return absl::OkStatus();
}

absl::Status JoinCluster(Config* config) {
  if (config->cluster.name.empty()) {
    config->server.cluster = Cluster::Alone(config->cluster.node_id);
    return absl::OkStatus();
  }
  absl::StatusOr<std::unique_ptr<Cluster>> cluster = Cluster::Join(config->cluster);
  if (!cluster.ok()) {
    return cluster.status();
  }
  config->server.cluster = *std::move(cluster);
  return absl::OkStatus();
}

}  // namespace procgen
