#ifndef SERVER_CONFIG_H_
#define SERVER_CONFIG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/cluster/cluster_options.h"
#include "server/fleet/nodes/fleet_options.h"
#include "server/logging/event_log.h"
#include "server/rpc/server.h"

namespace procgen {

// All that the program procgen-server is told by its flags.
struct Config {
  ServerOptions server;
  absl::Duration drain_timeout = absl::Seconds(10);  // after a signal to stop; [0 s, 1 h]
  LogLevel log_level = LogLevel::kInfo;
  std::string metrics_address;  // where metrics are served over HTTP, "HOST:PORT"; empty: nowhere

  // Where pages for browsers are served, "HOST:PORT"; empty: nowhere. By which names they may be
  // asked for besides, and how many may be open at a time.
  std::string web_address;
  std::vector<std::string> web_allowed_hosts;
  int32_t web_viewers_max = 64;

  // Which cluster it is a node of; no name: none.
  ClusterOptions cluster;
  bool draws_node_id = false;  // nobody gave a node_id, so that a random one was drawn

  // Pools are spread over the nodes of the cluster.
  bool is_fleet = false;
  FleetOptions fleet;
  std::string state_dir;  // where they are kept; empty: nowhere

  // Who may call. Paths of files; empty: none.
  TlsPaths tls;
  std::string tokens;
  // Others than this machine may reach a server that asks nobody who they are.
  bool allow_insecure = false;
  // As CloneSourceAllowlist reads it; empty: "local" where only this machine can reach this server,
  // else "none".
  std::string clone_source_allowlist;
};

// Errors: INVALID_ARGUMENT a value out of range, or two that contradict each other; the message
// names the flag, what was given and what is allowed.
absl::Status CheckConfig(const Config& config);

// Reads the files that `config` names for its server, and what it may clone from. REQUIRES:
// CheckConfig. Errors: a file that is missing or broken, or sources that are none; the message
// names the flag.
absl::Status LoadSecrets(Config* config);

// Opens the folder where a fleet keeps its pools, if it is given one. A fleet that nobody named is
// called by what the folder says, so that it keeps its node_id, too. REQUIRES: CheckConfig. Errors:
// a folder that cannot be used; the message names the flag.
absl::Status OpenStateDir(Config* config);

// Joins the cluster of `config`, if it has one, for its server. REQUIRES: CheckConfig. Errors: as
// Cluster::Join.
absl::Status JoinCluster(Config* config);

// Has the server of `config` be a fleet's, if it is to be one. REQUIRES: OpenStateDir, JoinCluster.
// Errors: INVALID_ARGUMENT flags that contradict each other.
absl::Status JoinFleet(Config* config);

}  // namespace procgen

#endif  // SERVER_CONFIG_H_
