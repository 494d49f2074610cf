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

// What a fleet shows its nodes; files, which are read with each connection. Empty: none.
struct FleetCredentials {
  std::string ca;           // PEM: who vouches for the nodes; empty: plain text
  std::string certificate;  // PEM, and its key
  std::string key;
  std::string token;  // a file with the token alone
};

struct FleetOptions {
  // The nodes of the cluster as they are known; called often, on any thread.
  std::function<std::vector<NodeStatus>()> nodes;
  // Has `changed` called when they have changed, until what is returned goes.
  std::function<Subscription(absl::AnyInvocable<void()> changed)> subscribe;
  FleetCredentials credentials;
  // After how many requests, or bytes of requests, the states of a shard are saved anew.
  int64_t snapshot_requests = 256;
  int64_t snapshot_bytes = int64_t{8} << 20;
  // What the log of a pool may take, where states cannot be saved or cannot be begun from: beyond
  // it only steps of all environments are taken, which may change that, and beyond 9 / 8 of it
  // nothing.
  int64_t log_bytes_max = int64_t{1} << 30;
  // Threads that the shards of all pools may have together, one each.
  int32_t shard_threads_max = kShardThreadsMax;
  // Where pools are kept, so that another process can go on with them; null: nowhere.
  std::shared_ptr<FleetState> state;
  // How many answers a learner whose connection broke may ask for again, at most.
  int32_t requests_in_flight_max = 16;
  // How long a request waits for nodes that can carry it out.
  absl::Duration failover_timeout = absl::Minutes(10);
  // How often pools poll their nodes though these do not seem to have changed: those that had
  // too little room may have more, and others may be less busy.
  absl::Duration poll_interval = absl::Seconds(1);
  Clock clock = SteadyNow;  // of suspicions; a test has its own
};

// Reads the files to see whether they can be used. Errors: INVALID_ARGUMENT, NOT_FOUND; the message
// names the flag.
absl::Status CheckFleetCredentials(const FleetCredentials& paths);

}  // namespace procgen

#endif  // SERVER_FLEET_NODES_FLEET_OPTIONS_H_
