#ifndef SERVER_FLEET_POOL_REMOTE_POOL_H_
#define SERVER_FLEET_POOL_REMOTE_POOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "procgen_client/batch.h"
#include "procgen_client/step_stream.h"
#include "server/fleet/log/logged_request.h"
#include "server/fleet/log/shard_checkpoint.h"
#include "server/fleet/nodes/fleet_nodes.h"
#include "server/fleet/pool/shard_context.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"

namespace procgen {

// One epoch of a shard: a pool on a node with the shard's environments, and the stream to it. It
// starts in the states of a checkpoint and advances along the request log.
// Environments are numbered from the first one of the shard. Each method validates the node's
// answers before they are used. A wrong answer excludes the node (FleetNodes::Distrust) and returns
// UNAVAILABLE. After an error the position is unknown: the shard destroys this and creates another
// one.
// Threads: compatible; methods block until the node has answered.
class RemotePool {
 public:
  // Creates the pool `pool_id` on `node`, in the states of `checkpoint`, and attaches to it.
  // Errors: those of the node, which then becomes suspect.
  static absl::StatusOr<std::unique_ptr<RemotePool>> Create(
      const ShardContext& context, Part range, const ShardCheckpoint& checkpoint,
      std::string pool_id, FleetNodes::CapacityReservation capacity,
      std::shared_ptr<NodeClient> node);
  // Ends the stream and deletes the pool in the background.
  ~RemotePool();
  RemotePool(const RemotePool&) = delete;
  RemotePool& operator=(const RemotePool&) = delete;

  const std::string& node_id() const { return node_->node_id; }
  const std::string& name() const { return name_; }
  // Shared with threads that cancel it while a method waits for the node.
  const std::shared_ptr<procgen_client::StepStream>& stream() const { return stream_; }
  // The log entry executed or replayed last.
  int64_t position() const { return position_; }
  // The level sampler in force there; null: none.
  const std::shared_ptr<const v1::LevelSampler>& sampler() const { return sampler_; }

  // Advances to log entry `number` and waits for all answers. Entries up to `replay_end` are
  // replayed without observations. If `number` is after it, entry `number` is executed in full,
  // into `answer`.
  absl::Status AdvanceTo(int64_t number, int64_t replay_end, procgen_client::Batch* answer);
  // Returns snapshots of environments, in this order; of all if the list is empty.
  absl::StatusOr<std::vector<std::string>> SaveStates(absl::Span<const int32_t> environments) const;
  // Renders environments; `frames`: uint8 [size_px, size_px, 3], one for each.
  absl::Status Render(absl::Span<const int32_t> environments, View view, int32_t size_px,
                      const std::vector<absl::Span<uint8_t>>& frames) const;

 private:
  RemotePool(const ShardContext& context, Part range, const ShardCheckpoint& checkpoint,
             std::string pool_id, FleetNodes::CapacityReservation capacity,
             std::shared_ptr<NodeClient> node);

  absl::Status CreatePool(const ShardCheckpoint& checkpoint);
  absl::Status Attach();
  // Sends an entry, if possible without waiting for its answer.
  absl::Status Replay(const LoggedRequest& logged);
  absl::Status Execute(const LoggedRequest& logged, procgen_client::Batch* answer);
  absl::Status ApplyStates(const LoggedRequest& logged);
  absl::Status ReceiveAll();
  absl::Status Distrust(const absl::Status& why) const;
  // Converts an error of the stream; the client also detects wrong answers.
  absl::Status StreamError(absl::Status status) const;

  const ShardContext& context_;
  const Part range_;
  const std::string pool_id_;
  FleetNodes::CapacityReservation capacity_;
  std::shared_ptr<NodeClient> node_;
  std::string name_;
  std::shared_ptr<procgen_client::StepStream> stream_;
  int64_t position_;
  std::shared_ptr<const v1::LevelSampler> sampler_;
  int32_t unanswered_ = 0;  // requests sent and not received
  // Answers to replayed requests. Separate from the shard's answer, which may still be read during
  // a replay: a shard that is done may lose its node while others still run.
  procgen_client::Batch replayed_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_REMOTE_POOL_H_
