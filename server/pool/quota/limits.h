#ifndef SERVER_POOL_QUOTA_LIMITS_H_
#define SERVER_POOL_QUOTA_LIMITS_H_

#include <cstdint>

namespace procgen {

// Limits of a server. Each has a flag of the same name and is reported by the catalog.
// A request beyond a limit gets RESOURCE_EXHAUSTED; the message contains the limit's name.
struct Limits {
  int32_t env_count_max = 16384;  // environments of all pools, and so pools, together
  // Of one owner. The default of the first equals the server's limit.
  int32_t owner_env_count_max = 16384;
  int64_t owner_bytes_max = int64_t{4} << 30;  // memory of pools (PoolBytes) and level samplers
  int32_t owner_call_count_max = 1024;         // calls in progress, with the streams of pools
  int64_t request_bytes_max = 4 << 20;         // one request message, in bytes
  int64_t response_bytes_max = 64 << 20;       // one response message, in bytes
  int32_t connection_count_max = 4096;         // of all callers together; not in the catalog
  // Episode history of all pools together, in bytes; 0: none is kept.
  int64_t episode_history_bytes_max = int64_t{256} << 20;
};

// Lower bound of a limit in bytes: a few observations.
inline constexpr int64_t kMessageBytesMin = 64 << 10;

// Memory that is reserved for a pool of `env_count` environments: of each 64 KiB and four
// observations, for two responses, an encoder and a watch.
inline constexpr int64_t PoolBytes(int64_t env_count, int64_t observation_bytes) {
  return env_count * ((64 << 10) + 4 * observation_bytes);
}

}  // namespace procgen

#endif  // SERVER_POOL_QUOTA_LIMITS_H_
