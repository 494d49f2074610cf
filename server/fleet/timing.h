#ifndef SERVER_FLEET_TIMING_H_
#define SERVER_FLEET_TIMING_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// The times of a fleet. How long a request waits for nodes is FleetOptions::failover_timeout. When
// the cluster drops a node is in server/cluster/timing.h.

// A node's connection sends a ping after this time of silence. Without an answer in time the node
// is dead.
inline constexpr absl::Duration kNodeKeepaliveTime = absl::Seconds(1);
inline constexpr absl::Duration kNodeKeepaliveTimeout = absl::Seconds(2);
inline constexpr absl::Duration kNodeConnectTimeout = absl::Seconds(1);
inline constexpr absl::Duration kNodeCallTimeout = absl::Seconds(20);

// How long other nodes are preferred to one that did not serve.
inline constexpr absl::Duration kNodeSuspicion = absl::Seconds(2);
// How long a node gets no shards that has answered wrongly: at first, doubled each time, and at
// most. After the latter without another wrong answer all is forgotten.
inline constexpr absl::Duration kNodeExclusionMin = absl::Seconds(1);
inline constexpr absl::Duration kNodeExclusionMax = absl::Minutes(5);

// How often a shard tries what fails for another reason than that its node is lost.
inline constexpr int kShardAttemptsMax = 3;
// Between attempts to find a node for a shard, if no node changes.
inline constexpr absl::Duration kShardPlaceRetry = absl::Milliseconds(200);
// How long a node keeps a shard without a stream.
inline constexpr int64_t kShardLeaseSeconds = 60;

// Between attempts to delete what fleets that are gone have left on nodes.
inline constexpr absl::Duration kOrphanRetryInterval = absl::Seconds(1);

}  // namespace procgen

#endif  // SERVER_FLEET_TIMING_H_
