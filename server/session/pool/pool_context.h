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

// What the pools of a server depend on. All of it must outlive them.
struct PoolContext {
  Quotas* quotas = nullptr;
  BackgroundExecutor* executor = nullptr;
  DeadlineTimer* lease_timer = nullptr;        // also provides the time
  ByteBudget* resume_buffer_bytes = nullptr;   // for kept answers
  ByteBudget* shared_memory_bytes = nullptr;   // for memory shared with learners
  ByteBudget* episode_bytes = nullptr;         // for the episode history
  std::atomic<int64_t>* step_count = nullptr;  // counts environment steps
  Metrics* metrics = nullptr;                  // all other counts
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_CONTEXT_H_
