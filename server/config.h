#ifndef SERVER_CONFIG_H_
#define SERVER_CONFIG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/cluster/cluster_options.h"
#include "server/logging/event_log.h"
#include "server/rpc/server.h"

namespace procgen {

// The configuration of procgen-server, from its flags.
struct Config {
  ServerOptions server;
  LogLevel log_level = LogLevel::kInfo;
  std::string metrics_address;  // serves metrics over HTTP, "HOST:PORT"; empty: none
  std::string art_dir;          // empty: built-in art

  // Address that serves pages to browsers, "HOST:PORT" (empty: none), additional host names by
  // which browsers may request them, and the limit of open pages.
  std::string web_address;
  std::vector<std::string> web_allowed_hosts;
  int32_t web_viewers_max = 64;

  // The cluster of this server; no name: none.
  ClusterOptions cluster;

  // Authentication: paths of files; empty: none.
  TlsPaths tls;
  std::string tokens;
  // Allows listening beyond loopback without TLS or without authentication.
  bool allow_insecure = false;
};

// Errors: INVALID_ARGUMENT a value out of range, or two contradictory ones; the message
// names the flag, what was given and what is allowed.
absl::Status CheckConfig(const Config& config);

// Reads the TLS and token files. REQUIRES: CheckConfig. Errors: a file is missing
// or invalid; the message names the flag.
absl::Status LoadSecrets(Config* config);

// Joins the cluster of `config`, if it is set. REQUIRES: CheckConfig. Errors: as
// Cluster::Join.
absl::Status JoinCluster(Config* config);

}  // namespace procgen

#endif  // SERVER_CONFIG_H_
