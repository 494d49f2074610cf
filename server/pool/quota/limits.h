#ifndef SERVER_POOL_QUOTA_LIMITS_H_
#define SERVER_POOL_QUOTA_LIMITS_H_

#include <cstdint>

namespace procgen {

// The limits of a server: LIMIT(name, default, least, most, what it limits). From this table come
// the members of Limits, the flags of procgen-server with their help and their ranges, and the
// catalog's limits (proto: Limits). A request beyond a limit gets RESOURCE_EXHAUSTED; the message
// contains the limit's name.
#define PROCGEN_LIMITS(LIMIT)                                                                     \
  LIMIT(env_count_max, 16384, 1, 1 << 20, "environments of all pools, and so pools")              \
  LIMIT(owner_env_count_max, 1 << 20, 1, 1 << 20,                                                 \
        "environments of the pools of one owner; --env_count_max if that is less")                \
  LIMIT(owner_bytes_max, int64_t{4} << 30, 64 << 10, int64_t{1} << 40,                            \
        "memory of one owner in bytes: of each environment of its pools 64 KiB and four "         \
        "observations, and of level samplers")                                                    \
  LIMIT(owner_call_count_max, 1024, 1, 1 << 20,                                                   \
        "calls of one owner in progress, with the streams of its pools")                          \
  LIMIT(request_bytes_max, 4 << 20, 64 << 10, INT32_MAX, "size of a request message in bytes")    \
  LIMIT(response_bytes_max, 64 << 20, 64 << 10, INT32_MAX, "size of a response message in bytes") \
  LIMIT(episode_history_bytes_max, int64_t{256} << 20, 0, int64_t{1} << 40,                       \
        "bytes of the history of the last episodes, of all pools; 0: no history")

// What is counted of each owner, and compared with its limit owner_<name>_max: QUOTA(name, what it
// counts).
#define PROCGEN_QUOTAS(QUOTA)                       \
  QUOTA(env_count, "environments")                  \
  QUOTA(bytes, "bytes of pools and level samplers") \
  QUOTA(call_count, "calls in progress")

struct Limits {
#define PROCGEN_MEMBER(name, value, least, most, what) int64_t name = value;
  PROCGEN_LIMITS(PROCGEN_MEMBER)
#undef PROCGEN_MEMBER
};

// Memory that is reserved for a pool of `env_count` environments: of each 64 KiB and four
// observations, for two responses, an encoder and a watch.
inline constexpr int64_t PoolBytes(int64_t env_count, int64_t observation_bytes) {
  return env_count * ((64 << 10) + 4 * observation_bytes);
}

}  // namespace procgen

#endif  // SERVER_POOL_QUOTA_LIMITS_H_
