#ifndef SERVER_FLEET_POOL_SHARD_THREAD_BUDGET_H_
#define SERVER_FLEET_POOL_SHARD_THREAD_BUDGET_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"

namespace procgen {

// The limit of the fleet's shard threads, over all pools. Threads are reserved before they are
// started, so that pools created at the same time do not exceed the limit.
// Threads: any method from any thread; none blocks.
class ShardThreadBudget {
 public:
  struct Release {
    void operator()(ShardThreadBudget* budget) const;
  };
  // One thread, until this is destroyed.
  using Reservation = std::unique_ptr<ShardThreadBudget, Release>;

  // Outlives its reservations.
  explicit ShardThreadBudget(int32_t thread_count_max) : thread_count_max_(thread_count_max) {}
  ShardThreadBudget(const ShardThreadBudget&) = delete;
  ShardThreadBudget& operator=(const ShardThreadBudget&) = delete;

  // Reserves `count` threads or, if fewer are available, all of these. Errors: RESOURCE_EXHAUSTED
  // none is available.
  absl::StatusOr<std::vector<Reservation>> Reserve(size_t count);
  // Number of threads available now.
  size_t available() const;

 private:
  const int32_t thread_count_max_;
  mutable absl::Mutex mutex_;
  int32_t reserved_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_SHARD_THREAD_BUDGET_H_
