#ifndef SERVER_CLUSTER_POOL_PLACEMENT_H_
#define SERVER_CLUSTER_POOL_PLACEMENT_H_

#include <cstdint>
#include <string>

namespace procgen {

// Where a shard of a fleet's pool is. The fleet server that deals the pool says so; fleet, pool and
// shard are the key, as two fleet servers may each have a pool of one name.
struct PoolPlacement {
  std::string fleet_id;  // whose pool it is: the node id of the fleet server
  std::string pool;      // the pool's name there, "pools/7", or with its owner "alice/pools/7"
  int32_t shard = 0;     // which part of it, >= 0
  std::string node_id;   // the host that has it
  // Rises each time the shard moves, while that fleet server runs; only the highest is answered
  // for.
  int64_t epoch = 0;

  friend bool operator==(const PoolPlacement&, const PoolPlacement&) = default;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_POOL_PLACEMENT_H_
