#ifndef SERVER_POOL_POOL_CONTEXT_H_
#define SERVER_POOL_POOL_CONTEXT_H_

#include <atomic>
#include <cstdint>

#include "server/concurrency/background_executor.h"
#include "server/metrics/metrics.h"
#include "server/pool/quota/byte_budget.h"

namespace procgen {

// What the pools of a server depend on. All of it must outlive them.
struct PoolContext {
  BackgroundExecutor* executor = nullptr;
  ByteBudget* episode_bytes = nullptr;         // for the episode history
  std::atomic<int64_t>* step_count = nullptr;  // counts environment steps
  Metrics* metrics = nullptr;                  // all other counts
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_CONTEXT_H_
