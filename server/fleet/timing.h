#ifndef SERVER_FLEET_TIMING_H_
#define SERVER_FLEET_TIMING_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// Intervals and timeouts of a fleet. The wait for usable nodes is FleetOptions::failover_timeout.
// When the cluster drops a node: server/cluster/timing.h.

// Idle time after which a node's connection sends a ping, and the timeout of its answer. After that
// the node is dead.
inline constexpr absl::Duration kNodeKeepaliveTime = absl::Seconds(1);
inline constexpr absl::Duration kNodeKeepaliveTimeout = absl::Seconds(2);
inline constexpr absl::Duration kNodeConnectTimeout = absl::Seconds(1);
inline constexpr absl::Duration kNodeCallTimeout = absl::Seconds(20);

// How long other nodes are preferred after a failure of a node.
inline constexpr absl::Duration kNodeSuspicion = absl::Seconds(2);
// How long a node gets no shards after a wrong answer: at first (doubled each time), and at most.
// Wrong answers are forgotten after the maximum time without another one.
inline constexpr absl::Duration kNodeExclusionMin = absl::Seconds(1);
inline constexpr absl::Duration kNodeExclusionMax = absl::Minutes(5);

// Attempts of a shard at an operation that fails for reasons other than the node.
inline constexpr int kShardAttemptsMax = 3;
// Interval of attempts to place a shard, if no node changes.
inline constexpr absl::Duration kShardPlaceRetry = absl::Milliseconds(200);
// Lease of a shard's pool on its node.
inline constexpr int64_t kShardLeaseSeconds = 60;

// Interval of attempts to delete orphans.
inline constexpr absl::Duration kOrphanRetryInterval = absl::Seconds(1);

}  // namespace procgen

#endif  // SERVER_FLEET_TIMING_H_
