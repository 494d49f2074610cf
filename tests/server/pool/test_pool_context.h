#ifndef TESTS_SERVER_POOL_TEST_POOL_CONTEXT_H_
#define TESTS_SERVER_POOL_TEST_POOL_CONTEXT_H_

#include <atomic>
#include <cstdint>

#include "server/pool/pool_context.h"

namespace procgen {

// A PoolContext with all that it refers to.
struct TestPoolContext {
  PoolContext Get() { return {&executor, &episode_bytes, &step_count, &metrics}; }

  Metrics metrics{"test"};
  std::atomic<int64_t> step_count = 0;
  ByteBudget episode_bytes{int64_t{1} << 30};
  BackgroundExecutor executor{1};
};

}  // namespace procgen

#endif  // TESTS_SERVER_POOL_TEST_POOL_CONTEXT_H_
