#ifndef SERVER_FLEET_LIMITS_H_
#define SERVER_FLEET_LIMITS_H_

#include <cstdint>

namespace procgen {

// Threads that the shards of all pools of a fleet have together, by default. Each shard has one,
// which blocks on its node; it counts against the limits of the process (ulimit -u, pids.max).
inline constexpr int32_t kShardThreadsMax = 1024;

}  // namespace procgen

#endif  // SERVER_FLEET_LIMITS_H_
