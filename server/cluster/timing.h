#ifndef SERVER_CLUSTER_TIMING_H_
#define SERVER_CLUSTER_TIMING_H_

#include "absl/time/time.h"

namespace procgen {

// A node announces its presence this often: often enough for kNodeLease to hold where two
// announcements are lost. Also how soon a node that could not be heard is seen again.
inline constexpr absl::Duration kPresenceInterval = absl::Milliseconds(400);
// A node that dies, or cannot be heard, is dropped after this.
inline constexpr absl::Duration kNodeLease = absl::Milliseconds(1500);
// A node that is heard, but has published no status for this long, is dropped, too: it hangs.
inline constexpr absl::Duration kStatusLifespan = absl::Seconds(4);

// The least time between two reports of changes; the first of a series is reported at once.
inline constexpr absl::Duration kTellIntervalMin = absl::Milliseconds(100);
// How soon what ends without a message (a lifespan, a rate) is noticed.
inline constexpr absl::Duration kRefreshInterval = absl::Milliseconds(200);
// How often the addresses of peers are resolved again.
inline constexpr absl::Duration kResolveInterval = absl::Seconds(3);
// How long a participant that replaces another may take to discover the same nodes.
inline constexpr absl::Duration kTakeOverTimeout = absl::Seconds(3);

}  // namespace procgen

#endif  // SERVER_CLUSTER_TIMING_H_
