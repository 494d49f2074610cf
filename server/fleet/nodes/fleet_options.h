#ifndef SERVER_FLEET_NODES_FLEET_OPTIONS_H_
#define SERVER_FLEET_NODES_FLEET_OPTIONS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/cluster/node_status.h"
#include "server/cluster/subscription.h"
#include "server/concurrency/deadline_timer.h"
#include "server/fleet/limits.h"
#include "server/fleet/log/fleet_state.h"

namespace procgen {

// Credentials that a fleet presents to its nodes: paths of files, read for each connection. Empty:
// none.
struct FleetCredentials {
  std::string ca;           // PEM of the CA of the nodes; empty: plain text
  std::string certificate;  // PEM; `key` is its private key
  std::string key;
  std::string token;  // path of a file that contains only the token
};

struct FleetOptions {
  // Returns the current nodes of the cluster. Called often, on any thread.
  std::function<std::vector<NodeStatus>()> nodes;
  // Calls `changed` when they have changed, until the returned subscription is destroyed.
  std::function<Subscription(absl::AnyInvocable<void()> changed)> subscribe;
  FleetCredentials credentials;
  // The states of a shard are saved after this many requests, or bytes of requests.
  int64_t snapshot_requests = 256;
  int64_t snapshot_bytes = int64_t{8} << 20;
  // Maximum bytes of a pool's log, if states cannot be saved or used. Beyond it only steps of all
  // environments are accepted, which may shorten it; beyond 9 / 8 of it no request is.
  int64_t log_bytes_max = int64_t{1} << 30;
  // Maximum shard threads of all pools; each shard has one.
  int32_t shard_threads_max = kShardThreadsMax;
  // Where pools are kept for the next process; null: nowhere.
  std::shared_ptr<FleetState> state;
  // Maximum number of answers that a reconnecting learner may request again.
  int32_t requests_in_flight_max = 16;
  // How long a request waits for usable nodes.
  absl::Duration failover_timeout = absl::Minutes(10);
  // How often pools poll their nodes even without a reported change: capacity and load may have
  // changed.
  absl::Duration poll_interval = absl::Seconds(1);
  Clock clock = SteadyNow;  // for suspicions; replaced in tests
};

// Reads the files to see whether they can be used. Errors: INVALID_ARGUMENT, NOT_FOUND; the message
// names the flag.
absl::Status CheckFleetCredentials(const FleetCredentials& paths);

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_FLEET_OPTIONS_H_
