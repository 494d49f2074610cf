#ifndef SERVER_FLEET_POOL_REBALANCER_H_
#define SERVER_FLEET_POOL_REBALANCER_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "procgen/v1/pools.pb.h"
#include "server/concurrency/background_executor.h"
#include "server/fleet/log/shard_checkpoint.h"
#include "server/fleet/nodes/fleet_nodes.h"
#include "server/fleet/pool/shard_context.h"
#include "server/fleet/pool/shard_set.h"

namespace procgen {

// Replaces the shards of a pool when nodes have joined or have free capacity again, so that
// environments are spread by capacity.
//
//     1. OnNodesChanged finds, twice in a row, that enough environments would move.
//     2. Before the next request, the states of all environments are saved as one checkpoint.
//     3. Before the first request for which observations can be drawn from that checkpoint, other
//        shards, which start from it, replace those of the pool.
//
// Threads: OnNodesChanged from any thread at any time; other methods one at a time, from any
// thread, while no shard runs.
class Rebalancer {
 public:
  // What is pointed to must outlive this.
  Rebalancer(std::shared_ptr<const ShardContext> context, int32_t env_count, ShardSet* shards,
             BackgroundExecutor* executor);

  void OnNodesChanged() ABSL_LOCKS_EXCLUDED(mutex_);
  // Does what is due before request `number`, then calls `run`: immediately, or on the executor.
  // `sampler`: currently in force; null: none.
  void BeforeRequest(int64_t number, std::shared_ptr<const v1::LevelSampler> sampler,
                     absl::AnyInvocable<void()> run);
  // Drops the checkpoint after a rollback of the log, which may remove the entries that made it
  // usable.
  void DiscardCheckpoint() { pending_.reset(); }
  // The checkpoint needs no log entry up to this number; INT64_MAX: there is no checkpoint.
  int64_t checkpoint_number() const;

 private:
  // Whether these assignments would move enough environments.
  bool IsWorthIt(const std::vector<ShardAssignment>& assignments) const;
  // Whether shards can start from the checkpoint before `number`. Drops a checkpoint that stays
  // unusable for long.
  bool CanRebalance(int64_t number);
  void Rebalance();
  void ReplaceShards(ShardSet::Shards shards) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::shared_ptr<const ShardContext> context_;
  const int32_t env_count_;
  ShardSet* const shards_;
  BackgroundExecutor* const executor_;
  std::optional<PendingCheckpoint> pending_;  // of all environments, at one position of the log
  std::atomic<bool> is_due_ = false;          // with the next request

  // Held while shards are replaced, and by OnNodesChanged, whose findings concern the current
  // shards.
  absl::Mutex mutex_;
  int32_t worth_it_count_ ABSL_GUARDED_BY(mutex_) = 0;  // times in a row
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_REBALANCER_H_
