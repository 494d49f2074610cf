#ifndef SERVER_SESSION_QUOTA_LIMITS_H_
#define SERVER_SESSION_QUOTA_LIMITS_H_

#include <cstdint>

#include "absl/time/time.h"

namespace procgen {

// What a server takes at most. Each has a flag of the same name, and is told in the catalog.
// Beyond one of them: RESOURCE_EXHAUSTED, and the message names it.
struct Limits {
  int32_t pool_count_max = 256;       // pools at a time
  int32_t pool_env_count_max = 4096;  // environments of one pool
  int32_t env_count_max = 16384;      // environments of all pools together
  // One observation of each environment of all pools together, in bytes. Stacks of frames are kept,
  // what seldom moves in a picture, and what an encoder has told, so memory follows it.
  int64_t observation_bytes_max = int64_t{4} << 30;
  int64_t request_bytes_max = 4 << 20;    // one request message, in bytes
  int64_t response_bytes_max = 64 << 20;  // one response message, in bytes
  int32_t requests_in_flight_max = 16;    // unanswered requests of one stream
  // What one owner may have of these at a time. As much as the server unless it is said.
  int32_t owner_pool_count_max = 256;
  int32_t owner_env_count_max = 16384;
  int32_t owner_stream_count_max = 256;  // attached; no pool has more than one
  int32_t owner_call_count_max = 1024;   // calls under way, and streams that have not attached
  int32_t owner_watch_count_max = 64;    // streams of WatchPool
  // Requests, responses and level samplers that are held for one owner, in bytes.
  int64_t owner_buffer_bytes_max = int64_t{1} << 30;
  int32_t connection_count_max = 4096;  // of all callers together
  // From the beginning of a stream until it has attached.
  absl::Duration attach_timeout = absl::Seconds(30);
  // Answers that are kept for streams that may be resumed, of all pools together, in bytes.
  int64_t resume_buffer_bytes_max = int64_t{4} << 30;
  // Memory that pools share with learners on the same machine, of all pools together, in bytes.
  int64_t shared_memory_bytes_max = int64_t{4} << 30;
  // What pools remember of episodes, of all together, in bytes; 0: nothing.
  int64_t episode_history_bytes_max = int64_t{256} << 20;
  // How long a pool may ask to live without a stream.
  absl::Duration lease_duration_max = absl::Hours(24);
};

// What a stream gets that asks for nothing else: what gRPC clients take by default, in bytes, and
// one request that is stepped while the next is on its way.
inline constexpr int64_t kResponseBytesDefault = 4 << 20;
inline constexpr int32_t kRequestsInFlightDefault = 2;
// Batches of shared memory that a learner may hold besides those of unanswered requests: by
// default, and at most.
inline constexpr int32_t kHeldBatchesDefault = 2;
inline constexpr int32_t kHeldBatchesMax = 1024;
// The least that a limit of bytes, or a stream, may ask for, in bytes: a few observations.
inline constexpr int64_t kMessageBytesMin = 64 << 10;
// The shortest lease.
inline constexpr absl::Duration kLeaseDurationMin = absl::Seconds(1);

}  // namespace procgen

#endif  // SERVER_SESSION_QUOTA_LIMITS_H_
