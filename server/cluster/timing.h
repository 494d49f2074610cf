#ifndef SERVER_CLUSTER_TIMING_H_
#define SERVER_CLUSTER_TIMING_H_

#include "absl/time/time.h"

namespace procgen {

// Minimum interval at which a node repeats its status. It grows with the number of nodes, so that a
// node sends at most kStatusesPerSecondMax.
inline constexpr absl::Duration kStatusIntervalMin = absl::Seconds(1);
inline constexpr int kStatusesPerSecondMax = 8;
// Time without a status after which a node is dropped: two lost ones drop no node of 64.
inline constexpr absl::Duration kNodeLease = absl::Seconds(20);
// Time without a Publish after which a node repeats its status no more: its server hangs.
inline constexpr absl::Duration kPublishTimeout = absl::Milliseconds(2500);

// Range of the interval of a participant's discovery messages (SPDP). It grows with the number of
// probed ports, to keep their rate.
inline constexpr absl::Duration kDiscoveryIntervalMin = absl::Seconds(15);
inline constexpr absl::Duration kDiscoveryIntervalMax = absl::Minutes(15);
inline constexpr int kDiscoveryMessagesPerSecondMax = 4;
// Time after which Cyclone DDS forgets a silent participant: this, or three discovery intervals.
inline constexpr absl::Duration kDiscoveryLeaseMin = absl::Minutes(1);

// Maximum and minimum interval of reading the status of the nodes.
inline constexpr absl::Duration kRefreshInterval = absl::Milliseconds(200);
inline constexpr absl::Duration kRefreshIntervalMin = absl::Milliseconds(20);
// Interval of resolving the addresses of peers.
inline constexpr absl::Duration kResolveInterval = absl::Seconds(3);
// Maximum time for a replacement participant to discover the same nodes, and time for them to
// receive its status.
inline constexpr absl::Duration kTakeOverTimeout = absl::Seconds(3);

}  // namespace procgen

#endif  // SERVER_CLUSTER_TIMING_H_
