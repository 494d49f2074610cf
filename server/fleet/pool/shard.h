#ifndef SERVER_FLEET_POOL_SHARD_H_
#define SERVER_FLEET_POOL_SHARD_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "procgen_client/batch.h"
#include "procgen_client/step_stream.h"
#include "server/concurrency/steady_time.h"
#include "server/fleet/log/shard_checkpoint.h"
#include "server/fleet/pool/checkpointer.h"
#include "server/fleet/pool/remote_pool.h"
#include "server/fleet/pool/shard_context.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"

namespace procgen {

// A contiguous range of a pool's environments, on one node at a time. It executes the pool's
// request log across node failures. When its node dies, drains or does not answer, the shard moves
// to another node, restarts from its checkpoint and replays the log.
//
// Each epoch of a shard is a RemotePool: a separate pool on the node, with a stream that ends with
// the epoch. A node that returns therefore cannot answer for environments that have moved.
//
// A thread of its own talks to the node and blocks there.
// Threads: one call at a time, from any thread, the next after `done`; OnNodesChanged and const
// methods from any thread at any time.
class Shard {
 public:
  using Done = absl::AnyInvocable<void(absl::Status)>;

  // `number`: of the shard in the life of its pool. `preferred_node`: where it is placed if there
  // is capacity. `reservation`: of its thread. Errors: RESOURCE_EXHAUSTED the thread cannot be
  // started.
  static absl::StatusOr<std::unique_ptr<Shard>> Create(
      std::shared_ptr<const ShardContext> context, int32_t number, Part range,
      std::shared_ptr<const ShardCheckpoint> checkpoint, std::string preferred_node,
      ShardThreadBudget::Reservation reservation);
  // Releases its resources on the node. REQUIRES: no call runs.
  ~Shard();
  Shard(const Shard&) = delete;
  Shard& operator=(const Shard&) = delete;

  const Part& range() const { return range_; }

  // Executes the log up to `number`; `done` is called on the shard's thread. Errors:
  // DEADLINE_EXCEEDED there was no node for FleetOptions::failover_timeout; errors that any node
  // would return. After an error only Rollback is allowed.
  void Run(int64_t number, Done done);
  // The node's answer to `number` of Run. Valid until the next call.
  const procgen_client::Batch& answer() const { return answer_; }
  // Snapshots of environments, in the shard's numbers. Errors: as Run.
  void Save(std::vector<int32_t> environments, std::vector<std::string>* snapshots, Done done);
  // Renders environments, in the shard's numbers; `frames`: uint8 [size_px, size_px, 3],
  // one for each. Errors: as Run.
  void Render(std::vector<int32_t> environments, View view, int32_t size_px,
              std::vector<absl::Span<uint8_t>> frames, Done done);
  // Restores the state after `number`, as if nothing later had been executed. Does not block.
  void Rollback(int64_t number);

  // Detaches from a node that is gone or draining: immediately, or after the current call.
  void OnNodesChanged();

  // The checkpoint that it restarts from. REQUIRES: no call runs.
  const std::shared_ptr<const ShardCheckpoint>& checkpoint() const {
    return checkpointer_.checkpoint();
  }
  // The shard needs no log entry up to this number.
  int64_t checkpoint_number() const { return checkpointer_.checkpoint_number(); }
  // The current node; empty: none.
  std::string node_id() const;

 private:
  struct Task {
    std::optional<int64_t> number;  // executes log entries up to this one; nullopt: none
    // runs afterwards; may be repeated; null: none
    absl::AnyInvocable<absl::Status(const RemotePool&)> work;
    Done done;
    absl::Time begin_time = SteadyNow();
  };

  Shard(std::shared_ptr<const ShardContext> context, int32_t number, Part range,
        std::shared_ptr<const ShardCheckpoint> checkpoint, std::string preferred_node,
        ShardThreadBudget::Reservation reservation);

  void Start(Task task);
  void RunUntilStopped();
  void RollbackNow(int64_t number);
  // Moves to another node if the shard has none or its node can no longer be used.
  void Reconcile();
  // Executes the task, on several nodes if necessary.
  absl::Status Execute(Task* task);
  // Advances the environments to `number`, on the current node or another one.
  absl::Status AdvanceTo(int64_t number);
  absl::Status Place();
  // Sets whether it waits for a node, and `why`; counts and logs a change.
  void SetWaits(bool waits, const absl::Status& why = absl::OkStatus());
  // Detaches from the failed node, and prefers others for a while.
  void MarkNodeFailed(const absl::Status& why);
  // Ends the epoch.
  void Detach();
  absl::Status TimeoutError(const absl::Status& last) const;
  void LogResumed(absl::Duration failover_time) const;
  bool Stops() const;

  const std::shared_ptr<const ShardContext> context_;
  const int32_t number_;
  const Part range_;
  const ShardThreadBudget::Reservation reservation_;  // of thread_

  // Used by its thread only.
  std::string preferred_node_;
  int32_t epoch_ = 0;
  Checkpointer checkpointer_;
  std::unique_ptr<RemotePool> remote_;  // null: it has no node
  bool waits_ = false;                  // for a node
  // The last error would be the same on any node; no node is tried before the next call.
  bool gives_up_ = false;
  int64_t executed_position_ = 0;  // entries up to here are replayed when it moves
  procgen_client::Batch answer_;

  mutable absl::Mutex mutex_;
  std::optional<Task> task_ ABSL_GUARDED_BY(mutex_);
  bool nodes_changed_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<int64_t> rollback_number_ ABSL_GUARDED_BY(mutex_);
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  // Of remote_.
  std::string node_id_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<procgen_client::StepStream> stream_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;  // runs RunUntilStopped
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_SHARD_H_
