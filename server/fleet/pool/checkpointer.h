#ifndef SERVER_FLEET_POOL_CHECKPOINTER_H_
#define SERVER_FLEET_POOL_CHECKPOINTER_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "server/fleet/log/shard_checkpoint.h"
#include "server/fleet/pool/remote_pool.h"
#include "server/fleet/pool/shard_context.h"
#include "server/session/backend/request.h"

namespace procgen {

// The checkpoint that a shard restarts from, and the next one: saved, but not yet usable.
// Threads: compatible; checkpoint_number from any thread at any time.
class Checkpointer {
 public:
  // `context` must outlive this.
  Checkpointer(const ShardContext& context, Part range,
               std::shared_ptr<const ShardCheckpoint> checkpoint);

  const std::shared_ptr<const ShardCheckpoint>& checkpoint() const { return checkpoint_; }
  // The shard needs no log entry up to this number.
  int64_t checkpoint_number() const { return checkpoint_number_; }

  // Replaces the checkpoint by the next one if that is usable when request `number` is executed.
  // REQUIRES: all shards of the pool have executed every entry before `number`, so that none rolls
  // back further.
  void Promote(int64_t number);
  // Saves the states of `pool` as the next checkpoint if one is due. Errors: those of the node. A
  // state that cannot be saved is not an error: it is logged and retried later.
  absl::Status SaveIfDue(const RemotePool& pool);
  // Drops the next checkpoint after a rollback of the log, which may remove the entries that made
  // it usable.
  void DiscardNext() { next_.reset(); }

 private:
  bool IsDue(int64_t position) const;

  const ShardContext& context_;
  const Part range_;
  std::shared_ptr<const ShardCheckpoint> checkpoint_;
  std::optional<PendingCheckpoint> next_;
  int64_t retry_position_ = 0;  // no states are saved before this position, after a failure
  std::atomic<int64_t> checkpoint_number_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_CHECKPOINTER_H_
