#ifndef PROCGEN_CLIENT_TIMING_H_
#define PROCGEN_CLIENT_TIMING_H_

#include "absl/time/time.h"

namespace procgen_client {

// The client's times that are no options; those are in ClientOptions and StreamOptions.

// Between attempts to resume a stream after its connection broke: doubled each time, and each half
// to one and a half of it, so that many learners do not reconnect at once.
inline constexpr absl::Duration kResumeBackoffMin = absl::Milliseconds(20);
inline constexpr absl::Duration kResumeBackoffMax = absl::Seconds(2);
// Between attempts of gRPC to connect.
inline constexpr absl::Duration kReconnectBackoffMin = absl::Milliseconds(100);
inline constexpr absl::Duration kReconnectBackoffMax = absl::Seconds(1);
// How long a server may take to end a stream that is over.
inline constexpr absl::Duration kEndTimeout = absl::Seconds(10);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_TIMING_H_
