#ifndef SERVER_FLEET_POOL_SHARD_SET_H_
#define SERVER_FLEET_POOL_SHARD_SET_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/types/span.h"
#include "server/fleet/log/journal.h"
#include "server/fleet/nodes/fleet_nodes.h"
#include "server/fleet/pool/shard.h"
#include "server/fleet/pool/shard_context.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"

namespace procgen {

// Splits `checkpoint`, of a whole pool, into checkpoints of shards of these sizes.
ShardCheckpoints SplitCheckpoint(const ShardCheckpoint& checkpoint,
                                 const std::vector<ShardAssignment>& assignments);

// The shards of a pool, in the order of their environments, and calls that concern several of them.
// Threads: one call at a time, from any thread, the next after `done`; OnNodesChanged from any
// thread at any time.
class ShardSet {
 public:
  using Shards = std::vector<std::unique_ptr<Shard>>;
  using Done = Shard::Done;
  using SaveDone = std::function<void(absl::StatusOr<std::vector<std::string>>)>;

  explicit ShardSet(std::shared_ptr<const ShardContext> context) : context_(std::move(context)) {}

  // Makes a shard for each of `checkpoints`, outside the set. `assignments`: their preferred nodes,
  // in the same order; empty: any. `threads`: reserved for them, at least one each. Errors: as
  // Shard::Create.
  absl::StatusOr<Shards> Make(const ShardCheckpoints& checkpoints,
                              const std::vector<ShardAssignment>& assignments,
                              std::vector<ShardThreadBudget::Reservation> threads);
  // As above, and reserves the threads. Errors: RESOURCE_EXHAUSTED too few are available; those of
  // Shard::Create.
  absl::StatusOr<Shards> Make(const ShardCheckpoints& checkpoints,
                              const std::vector<ShardAssignment>& assignments);
  // Replaces the shards of the set and returns the previous ones.
  Shards Replace(Shards shards) ABSL_LOCKS_EXCLUDED(mutex_);

  bool empty() const { return shards_.empty(); }
  // The current nodes of the shards.
  std::vector<ShardAssignment> assignments() const;
  // Their checkpoints.
  ShardCheckpoints checkpoints() const;
  // The shards need no log entry up to this number.
  int64_t checkpoint_number() const;
  // All shards; those that overlap `range`; those that contain any of `environments`.
  std::vector<Shard*> all() const { return Overlapping({0, INT32_MAX}); }
  std::vector<Shard*> Overlapping(Part range) const;
  std::vector<Shard*> Containing(const std::vector<int32_t>& environments) const;

  // As Shard::Run, for several shards. `done` gets the first error.
  static void Run(const std::vector<Shard*>& shards, int64_t number, Done done);
  // As Shard::Rollback, for all shards.
  void Rollback(int64_t number);
  // Returns snapshots of environments of the pool, in this order.
  void Save(const std::vector<int32_t>& environments, SaveDone done);
  // Renders environments of the pool; `frames`: uint8 [size_px, size_px, 3], one for each.
  void Render(const std::vector<int32_t>& environments, View view, int32_t size_px,
              const std::vector<absl::Span<uint8_t>>& frames, Done done);

  // As Shard::OnNodesChanged, for all shards. Returns their nodes.
  std::vector<ShardAssignment> OnNodesChanged() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Environments of one shard, numbered in it, and their indices in a list of environments of the
  // pool.
  struct Selection {
    Shard* shard = nullptr;
    std::vector<int32_t> environments;
    std::vector<size_t> places;
  };

  size_t IndexOf(int32_t environment) const;
  // Selects from the shards that contain any of `environments`.
  std::vector<Selection> Select(const std::vector<int32_t>& environments) const;

  const std::shared_ptr<const ShardContext> context_;
  int32_t shard_number_ = 0;  // of the last shard that was made
  absl::Mutex mutex_;         // held to change shards_, and by OnNodesChanged
  Shards shards_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_SHARD_SET_H_
