#include "server/flags.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "envcore/pool/cpu_count.h"
#include "envcore/pool/shared_art.h"

#define PROCGEN_FLAG(name, value, least, most, what) \
  ABSL_FLAG(int64_t, name, value, absl::StrCat(what, "; ", least, " to ", most));
PROCGEN_LIMITS(PROCGEN_FLAG)
#undef PROCGEN_FLAG

ABSL_FLAG(std::string, address, "127.0.0.1:50051",
          "address to listen on: HOST:PORT (port 0: any free port, which is printed) or unix:PATH");
ABSL_FLAG(int32_t, workers, 0,
          "threads that step environments; 0: one per core available to the process (CPU affinity, "
          "cgroup quota)");
ABSL_FLAG(absl::Duration, keepalive_time, procgen::ServerOptions().keepalive_time,
          "idle time after which the server sends a keepalive ping, with its unit: 30s, 500ms");
ABSL_FLAG(absl::Duration, keepalive_timeout, procgen::ServerOptions().keepalive_timeout,
          "time without a reply to the ping after which the connection is closed, likewise");
ABSL_FLAG(
    std::string, art_dir, "",
    "folder of art in the layout of Procgen 0.10.7 that all pools draw with; empty: built-in art");
ABSL_FLAG(
    std::string, metrics_address, "",
    "address that serves metrics for Prometheus over HTTP at /metrics: HOST:PORT (port 0: any free "
    "port, which is logged); empty: none");
ABSL_FLAG(std::string, log_level, "info",
          "minimum level of log lines: debug, info, warning or error");
ABSL_FLAG(std::string, tls_certificate, "",
          "PEM file of the server's certificate chain, its own first; read again when it changes. "
          "Empty: plain text");
ABSL_FLAG(std::string, tls_key, "", "PEM file of the key of --tls_certificate");
ABSL_FLAG(std::string, tls_client_ca, "",
          "PEM file of authorities; clients must present a certificate signed by one of them. "
          "Empty: clients need no certificate");
ABSL_FLAG(std::string, tokens, "",
          "file of lines 'OWNER TOKEN'; every call must carry one; read again when it changes. "
          "Empty: calls need no token");
ABSL_FLAG(
    bool, allow_insecure, false,
    "allow listening beyond loopback without TLS or without authentication, also for metrics and "
    "pages");
ABSL_FLAG(std::string, cluster, "",
          "name of this server's cluster: servers with the same name and domain find each other. "
          "Empty: none");
ABSL_FLAG(int32_t, cluster_domain, 0, "DDS domain number, which determines the ports: 0 to 230");
ABSL_FLAG(std::vector<std::string>, cluster_peers, {},
          "hosts of the other nodes, comma-separated, for networks without multicast: names or "
          "IPv4 addresses; a name may have several addresses. Empty: multicast");
ABSL_FLAG(std::string, node_id, "",
          "name of this server, unique in its cluster. Empty: a random name");
ABSL_FLAG(std::string, advertised_address, "",
          "address where clients and nodes reach this server: HOST:PORT (port 0: the listening "
          "port) or unix:PATH. Empty: --address");
ABSL_FLAG(
    std::string, web_address, "",
    "address that serves the live view, play, replays and the gallery to browsers: HOST:PORT (port "
    "0: any free port, which is logged); empty: none");
ABSL_FLAG(std::vector<std::string>, web_allowed_hosts, {},
          "host names by which browsers may request the pages, comma-separated, besides localhost "
          "and the addresses of --web_address");
ABSL_FLAG(int32_t, web_viewers_max, procgen::Config().web_viewers_max, "open pages");

namespace procgen {
namespace {

absl::StatusOr<LogLevel> FindLogLevel(const std::string& name) {
  for (const auto& [level_name, level] :
       {std::pair("debug", LogLevel::kDebug), std::pair("info", LogLevel::kInfo),
        std::pair("warning", LogLevel::kWarning), std::pair("error", LogLevel::kError)}) {
    if (name == level_name) {
      return level;
    }
  }
  return absl::InvalidArgumentError(
      absl::StrCat("--log_level is '", name, "', allowed: debug, info, warning, error"));
}

std::string RandomNodeId() {
  std::random_device random;
  return absl::StrCat("node-", absl::Hex(random(), absl::kZeroPad8));
}

Limits ReadLimits() {
  Limits limits;
#define PROCGEN_READ(name, value, least, most, what) limits.name = absl::GetFlag(FLAGS_##name);
  PROCGEN_LIMITS(PROCGEN_READ)
#undef PROCGEN_READ
  limits.owner_env_count_max = std::min(limits.owner_env_count_max, limits.env_count_max);
  return limits;
}

}  // namespace

absl::StatusOr<Config> ReadFlags() {
  absl::StatusOr<LogLevel> log_level = FindLogLevel(absl::GetFlag(FLAGS_log_level));
  if (!log_level.ok()) {
    return log_level.status();
  }
  Config config;
  config.log_level = *log_level;
  config.metrics_address = absl::GetFlag(FLAGS_metrics_address);
  config.tls.certificate = absl::GetFlag(FLAGS_tls_certificate);
  config.tls.key = absl::GetFlag(FLAGS_tls_key);
  config.tls.client_ca = absl::GetFlag(FLAGS_tls_client_ca);
  config.tokens = absl::GetFlag(FLAGS_tokens);
  config.allow_insecure = absl::GetFlag(FLAGS_allow_insecure);
  config.web_address = absl::GetFlag(FLAGS_web_address);
  config.web_allowed_hosts = absl::GetFlag(FLAGS_web_allowed_hosts);
  config.web_viewers_max = absl::GetFlag(FLAGS_web_viewers_max);

  ServerOptions& server = config.server;
  server.address = absl::GetFlag(FLAGS_address);
  server.advertised_address = absl::GetFlag(FLAGS_advertised_address);
  server.worker_count = absl::GetFlag(FLAGS_workers);
  if (server.worker_count == 0) {
    server.worker_count = CpuCount();
  }
  server.limits = ReadLimits();
  server.keepalive_time = absl::GetFlag(FLAGS_keepalive_time);
  server.keepalive_timeout = absl::GetFlag(FLAGS_keepalive_timeout);

  ClusterOptions& cluster = config.cluster;
  cluster.name = absl::GetFlag(FLAGS_cluster);
  cluster.domain_id = absl::GetFlag(FLAGS_cluster_domain);
  cluster.peers = absl::GetFlag(FLAGS_cluster_peers);
  cluster.node_id = absl::GetFlag(FLAGS_node_id);
  if (cluster.node_id.empty()) {
    cluster.node_id = RandomNodeId();
  }
  cluster.address = server.advertised_address.empty() ? server.address : server.advertised_address;

  if (absl::Status status = CheckConfig(config); !status.ok()) {
    return status;
  }
  if (absl::Status status = LoadSecrets(&config); !status.ok()) {
    return status;
  }
  config.art_dir = absl::GetFlag(FLAGS_art_dir);
  if (!config.art_dir.empty()) {
    auto art = SharedArt::LoadFolder(config.art_dir);
    if (!art.ok()) {
      return absl::Status(art.status().code(), absl::StrCat("--art_dir: ", art.status().message()));
    }
    server.art = *std::move(art);
  }
  return config;
}

}  // namespace procgen
