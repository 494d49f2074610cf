#ifndef SERVER_CLUSTER_TIMING_H_
#define SERVER_CLUSTER_TIMING_H_

#include "absl/time/time.h"

namespace procgen {

// Interval of a node's announcements: kNodeLease holds even if two are lost. Also the delay until a
// node that could not be heard is seen again.
inline constexpr absl::Duration kPresenceInterval = absl::Milliseconds(400);
// Time without an announcement after which a node is dropped.
inline constexpr absl::Duration kNodeLease = absl::Milliseconds(1500);
// Time without a published status after which a node is dropped: it hangs.
inline constexpr absl::Duration kStatusLifespan = absl::Seconds(4);

// Minimum time between two reports of changes; the first of a series is reported immediately.
inline constexpr absl::Duration kTellIntervalMin = absl::Milliseconds(100);
// Delay until an end without a message (of a lifespan, a rate) is noticed.
inline constexpr absl::Duration kRefreshInterval = absl::Milliseconds(200);
// Interval of resolving the addresses of peers.
inline constexpr absl::Duration kResolveInterval = absl::Seconds(3);
// Maximum time for a replacement participant to discover the same nodes.
inline constexpr absl::Duration kTakeOverTimeout = absl::Seconds(3);

}  // namespace procgen

#endif  // SERVER_CLUSTER_TIMING_H_
