#ifndef SERVER_SESSION_QUOTA_LIMITS_H_
#define SERVER_SESSION_QUOTA_LIMITS_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// Limits of a server. Each has a flag of the same name and is reported by the catalog.
// A request beyond a limit gets RESOURCE_EXHAUSTED; the message contains the limit's name.
struct Limits {
  int32_t pool_count_max = 256;       // pools at a time
  int32_t pool_env_count_max = 4096;  // environments of one pool
  int32_t env_count_max = 16384;      // environments of all pools together
  // One observation of each environment of all pools together, in bytes. Frame stacks, static
  // layers and encoder state have the size of observations, so this also bounds their memory.
  int64_t observation_bytes_max = int64_t{4} << 30;
  int64_t request_bytes_max = 4 << 20;    // one request message, in bytes
  int64_t response_bytes_max = 64 << 20;  // one response message, in bytes
  int32_t requests_in_flight_max = 16;    // unanswered requests of one stream
  // Limits per owner. The defaults equal the server's limits.
  int32_t owner_pool_count_max = 256;
  int32_t owner_env_count_max = 16384;
  int32_t owner_stream_count_max = 256;  // attached; no pool has more than one
  int32_t owner_call_count_max = 1024;   // calls in progress, and streams that have not attached
  int32_t owner_watch_count_max = 64;    // streams of WatchPool
  // Requests, responses and level samplers held for one owner, in bytes.
  int64_t owner_buffer_bytes_max = int64_t{1} << 30;
  int32_t connection_count_max = 4096;  // of all callers together
  // Time from the start of a stream until it must have attached.
  absl::Duration attach_timeout = absl::Seconds(30);
  // Answers kept for resumable streams, of all pools together, in bytes.
  int64_t resume_buffer_bytes_max = int64_t{4} << 30;
  // Memory shared with learners on the same machine, of all pools together, in bytes.
  int64_t shared_memory_bytes_max = int64_t{4} << 30;
  // Episode history of all pools together, in bytes; 0: none is kept.
  int64_t episode_history_bytes_max = int64_t{256} << 20;
  // Longest lease of a pool.
  absl::Duration lease_duration_max = absl::Hours(24);
  // Lease of pools whose learners choose none; infinite: no lease.
  absl::Duration lease_duration_default = absl::Minutes(10);
};

// Defaults of a stream: gRPC clients' default message limit, in bytes, and enough requests in
// flight to step one while the next arrives.
inline constexpr int64_t kResponseBytesDefault = 4 << 20;
inline constexpr int32_t kRequestsInFlightDefault = 2;
// Batches of shared memory that a learner may hold besides those of unanswered requests: default
// and maximum.
inline constexpr int32_t kHeldBatchesDefault = 2;
inline constexpr int32_t kHeldBatchesMax = 1024;
// Lower bound of a limit in bytes, and of a stream's response bytes: a few observations.
inline constexpr int64_t kMessageBytesMin = 64 << 10;
// The shortest lease.
inline constexpr absl::Duration kLeaseDurationMin = absl::Seconds(1);

}  // namespace procgen

#endif  // SERVER_SESSION_QUOTA_LIMITS_H_
