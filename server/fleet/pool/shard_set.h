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

// The checkpoints of shards of these sizes, cut from `checkpoint`, a checkpoint of the whole pool.
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

  // Makes a shard for each of `checkpoints`, which is not in the set yet. `assignments`: where they
  // are placed if there is room, in the same order; empty: anywhere. `threads`: reserved for them,
  // at least one each. Errors: as Shard::Create.
  absl::StatusOr<Shards> Make(const ShardCheckpoints& checkpoints,
                              const std::vector<ShardAssignment>& assignments,
                              std::vector<ShardThreadBudget::Reservation> threads);
  // The same, with threads that are reserved now. Errors: RESOURCE_EXHAUSTED too few are left; as
  // Shard::Create.
  absl::StatusOr<Shards> Make(const ShardCheckpoints& checkpoints,
                              const std::vector<ShardAssignment>& assignments);
  // Puts other shards into the set and returns those that were there.
  Shards Replace(Shards shards) ABSL_LOCKS_EXCLUDED(mutex_);

  bool empty() const { return shards_.empty(); }
  // Where the shards are.
  std::vector<ShardAssignment> assignments() const;
  // Their checkpoints.
  ShardCheckpoints checkpoints() const;
  // The shards need no log entry up to this number.
  int64_t checkpoint_number() const;
  // All, those that have one of `range`, or one of `environments`.
  std::vector<Shard*> all() const { return Overlapping({0, INT32_MAX}); }
  std::vector<Shard*> Overlapping(Part range) const;
  std::vector<Shard*> Containing(const std::vector<int32_t>& environments) const;

  // As Shard::Run, of several shards. `done` gets the first error.
  static void Run(const std::vector<Shard*>& shards, int64_t number, Done done);
  // As Shard::Rollback, of all shards.
  void Rollback(int64_t number);
  // Snapshots of environments of the pool, in this order.
  void Save(const std::vector<int32_t>& environments, SaveDone done);
  // Renders environments of the pool; `frames`: uint8 [size_px, size_px, 3], one for each.
  void Render(const std::vector<int32_t>& environments, View view, int32_t size_px,
              const std::vector<absl::Span<uint8_t>>& frames, Done done);

  // As Shard::OnNodesChanged, of all shards; returns where they are.
  std::vector<ShardAssignment> OnNodesChanged() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Environments of one shard, in its numbers, and their places in a list of environments of the
  // pool.
  struct Selection {
    Shard* shard = nullptr;
    std::vector<int32_t> environments;
    std::vector<size_t> places;
  };

  size_t IndexOf(int32_t environment) const;
  // Of the shards that have one of `environments`.
  std::vector<Selection> Select(const std::vector<int32_t>& environments) const;

  const std::shared_ptr<const ShardContext> context_;
  int32_t shard_number_ = 0;  // of the last shard that was made
  absl::Mutex mutex_;         // held to change shards_, and by OnNodesChanged
  Shards shards_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_SHARD_SET_H_
