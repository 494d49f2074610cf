#ifndef PROCGEN_CLIENT_INTERNAL_TIMING_H_
#define PROCGEN_CLIENT_INTERNAL_TIMING_H_

#include "absl/time/time.h"

namespace procgen_client {

// Fixed times of the client. Configurable ones are in ConnectOptions and RecoveryOptions.

// Backoff between attempts to continue a pool; doubles each time.
inline constexpr absl::Duration kResumeBackoffMin = absl::Milliseconds(20);
inline constexpr absl::Duration kResumeBackoffMax = absl::Milliseconds(500);
// Backoff between gRPC's attempts to connect.
inline constexpr absl::Duration kReconnectBackoffMin = absl::Milliseconds(100);
inline constexpr absl::Duration kReconnectBackoffMax = absl::Seconds(1);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_TIMING_H_
