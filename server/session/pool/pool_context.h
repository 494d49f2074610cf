#ifndef SERVER_SESSION_POOL_POOL_CONTEXT_H_
#define SERVER_SESSION_POOL_POOL_CONTEXT_H_

#include <atomic>
#include <cstdint>

#include "server/concurrency/background_executor.h"
#include "server/concurrency/deadline_timer.h"
#include "server/metrics/metrics.h"
#include "server/session/quota/byte_budget.h"
#include "server/session/quota/quotas.h"

namespace procgen {

// What all pools of a server share. All of it must outlive them.
struct PoolContext {
  Quotas* quotas = nullptr;
  BackgroundExecutor* executor = nullptr;
  DeadlineTimer* lease_timer = nullptr;        // also tells the time
  ByteBudget* resume_buffer_bytes = nullptr;   // for the answers that they keep
  ByteBudget* shared_memory_bytes = nullptr;   // for what they share with learners
  ByteBudget* episode_bytes = nullptr;         // for the episodes that they remember
  std::atomic<int64_t>* step_count = nullptr;  // environment steps are added to it
  Metrics* metrics = nullptr;                  // and all else that is counted to these
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_CONTEXT_H_
