#ifndef SERVER_FLEET_POOL_SHARD_CONTEXT_H_
#define SERVER_FLEET_POOL_SHARD_CONTEXT_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "procgen/v1/pools.pb.h"
#include "server/fleet/log/pool_log.h"
#include "server/fleet/nodes/fleet_nodes.h"
#include "server/fleet/nodes/orphan_collector.h"
#include "server/fleet/pool/shard_thread_budget.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/request.h"

namespace procgen {

// What the shards of one pool share. The objects pointed to must outlive the shards.
struct ShardContext {
  std::string owner;             // of the pool
  std::string label;             // the pool's name in log events
  std::string id_prefix;         // prefix of the ids of its pools on the nodes
  v1::PoolSpec spec;             // of the whole pool, without a level sampler
  size_t observation_bytes = 0;  // of one environment
  const FleetOptions* options = nullptr;
  FleetNodes* nodes = nullptr;
  OrphanCollector* orphan_collector = nullptr;
  ShardThreadBudget* threads = nullptr;
  Metrics* metrics = nullptr;
  PoolLog* log = nullptr;
  // Number of last requests that a shard must be able to execute again, with their answers.
  int64_t answers_kept = 0;
};

// A range of environments in log events and errors, such as "0 to 7".
inline std::string RangeText(Part range) {
  return absl::StrCat(range.first, " to ", range.first + range.count - 1);
}

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_SHARD_CONTEXT_H_
