#ifndef SERVER_FLEET_LIMITS_H_
#define SERVER_FLEET_LIMITS_H_

#include <cstdint>

namespace procgen {

// Default limit of the shard threads of a fleet, over all pools. Each shard has one, which blocks
// on its node; it counts against the limits of the process (ulimit -u, pids.max).
inline constexpr int32_t kShardThreadsMax = 1024;

}  // namespace procgen

#endif  // SERVER_FLEET_LIMITS_H_
