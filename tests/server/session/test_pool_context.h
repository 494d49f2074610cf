#ifndef TESTS_SERVER_SESSION_TEST_POOL_CONTEXT_H_
#define TESTS_SERVER_SESSION_TEST_POOL_CONTEXT_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/session/backend/local_pool.h"
#include "server/session/pool/pool_session.h"

namespace procgen {

// A manual clock.
class TestClock {
 public:
  absl::Time Now() const {
    absl::MutexLock lock(&mutex_);
    return now_;
  }
  void Advance(absl::Duration duration) {
    absl::MutexLock lock(&mutex_);
    now_ += duration;
  }

 private:
  mutable absl::Mutex mutex_;
  absl::Time now_ = absl::UnixEpoch() + absl::Hours(1);
};

// A PoolContext with a manual clock.
struct TestPoolContext {
  explicit TestPoolContext(const Limits& limits = {}) : quotas(limits) {}

  PoolContext Get() {
    return {&quotas,        &executor,   &lease_timer, &resume_buffer_bytes, &shared_memory_bytes,
            &episode_bytes, &step_count, &metrics};
  }

  // The backend of a local pool.
  std::unique_ptr<PoolBackend> Backend(std::unique_ptr<Pool> pool) {
    return std::make_unique<LocalPool>(std::move(pool), "", &executor);
  }

  TestClock clock;
  Metrics metrics{"test"};
  std::atomic<int64_t> step_count = 0;
  Quotas quotas;
  ByteBudget resume_buffer_bytes{int64_t{1} << 30};
  ByteBudget shared_memory_bytes{int64_t{1} << 30};
  ByteBudget episode_bytes{int64_t{1} << 30};
  BackgroundExecutor executor{1};
  // Never fires: tests query the pool.
  DeadlineTimer lease_timer{[this] { return clock.Now(); },
                            [](absl::Time /*now*/) { return absl::InfiniteFuture(); }};
};

}  // namespace procgen

#endif  // TESTS_SERVER_SESSION_TEST_POOL_CONTEXT_H_
