#ifndef SERVER_CLUSTER_TIMING_H_
#define SERVER_CLUSTER_TIMING_H_

#include "absl/time/time.h"

namespace procgen {

// Interval of a node's heartbeats: kNodeLease holds even if two are lost.
inline constexpr absl::Duration kHeartbeatInterval = absl::Milliseconds(400);
// Time without a heartbeat after which a node is dropped.
inline constexpr absl::Duration kNodeLease = absl::Milliseconds(1500);
// Time for the first heartbeat, before the lease begins: of a node that is newly monitored, or
// lost.
inline constexpr absl::Duration kFirstHeartbeatTimeout = absl::Seconds(2);
// Minimum interval of changes of the monitored nodes, each of which all nodes learn from Cyclone
// DDS. Bounds the traffic when many nodes join, or a busy machine delays heartbeats.
inline constexpr absl::Duration kMonitorIntervalMin = absl::Seconds(2);
// Time without a Publish after which a node sends no more heartbeats: its server hangs.
inline constexpr absl::Duration kPublishTimeout = absl::Milliseconds(2500);

// Range of the interval of a participant's discovery messages (SPDP). It grows with the number of
// probed ports, to keep their rate.
inline constexpr absl::Duration kDiscoveryIntervalMin = absl::Seconds(15);
inline constexpr absl::Duration kDiscoveryIntervalMax = absl::Minutes(15);
inline constexpr int kDiscoveryMessagesPerSecondMax = 6;
// Time after which Cyclone DDS forgets a silent participant: this, or three discovery intervals.
inline constexpr absl::Duration kDiscoveryLeaseMin = absl::Minutes(1);

// A change of a node's rate alone is sent to this many nodes per second, so less often in a large
// cluster.
inline constexpr int kRatesPerSecondMax = 16;

// Minimum time between two reports of changes; the first of a series is reported immediately.
inline constexpr absl::Duration kTellIntervalMin = absl::Milliseconds(100);
// Maximum and minimum interval of reading the status of the nodes and their heartbeats.
inline constexpr absl::Duration kRefreshInterval = absl::Milliseconds(200);
inline constexpr absl::Duration kRefreshIntervalMin = absl::Milliseconds(20);
// Interval of resolving the addresses of peers.
inline constexpr absl::Duration kResolveInterval = absl::Seconds(3);
// Maximum time for a replacement participant to discover the same nodes.
inline constexpr absl::Duration kTakeOverTimeout = absl::Seconds(3);

}  // namespace procgen

#endif  // SERVER_CLUSTER_TIMING_H_
