#ifndef PROCGEN_CLIENT_INTERNAL_TIMING_H_
#define PROCGEN_CLIENT_INTERNAL_TIMING_H_

#include "absl/time/time.h"

namespace procgen_client {

// Fixed times of the client. Configurable ones are in ConnectOptions and RecoveryOptions.

// Backoff between attempts to continue a pool: doubles each time, with a jitter of 0.5 to 1.5 so
// that learners do not reconnect at the same time.
inline constexpr absl::Duration kResumeBackoffMin = absl::Milliseconds(20);
inline constexpr absl::Duration kResumeBackoffMax = absl::Milliseconds(500);
// Backoff between gRPC's attempts to connect.
inline constexpr absl::Duration kReconnectBackoffMin = absl::Milliseconds(100);
inline constexpr absl::Duration kReconnectBackoffMax = absl::Seconds(1);
// Time in which gRPC reports the end of a stream after its last response. Only a stream with a
// malformed response takes longer.
inline constexpr absl::Duration kEndReportTimeout = absl::Seconds(2);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_TIMING_H_
