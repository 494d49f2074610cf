#ifndef SERVER_FLEET_POOL_SHARD_H_
#define SERVER_FLEET_POOL_SHARD_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
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
#include "procgen/v1/pools.pb.h"
#include "procgen_client/batch.h"
#include "procgen_client/step_stream.h"
#include "server/concurrency/steady_time.h"
#include "server/fleet/log/request_log.h"
#include "server/fleet/log/shard_base.h"
#include "server/fleet/nodes/fleet_nodes.h"
#include "server/fleet/nodes/leftovers.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"

namespace procgen {

// What all shards of a pool have in common. What is pointed to must outlive them.
struct ShardTerms {
  std::string owner;             // of the pool
  std::string label;             // what log lines call the pool
  std::string id_prefix;         // what the ids of its pools on the nodes begin with
  v1::PoolSpec spec;             // of the whole pool, without a level sampler
  size_t observation_bytes = 0;  // of one environment
  const FleetOptions* options = nullptr;
  FleetNodes* nodes = nullptr;
  Leftovers* leftovers = nullptr;
  Metrics* metrics = nullptr;
  const RequestLog* log = nullptr;
  // How many requests a shard must be able to carry out again with their answers.
  int64_t answers_kept = 0;
  // Is told where a shard begins anew from now on; null: nobody is.
  std::function<void(Part range, std::shared_ptr<const ShardBase> base)> on_base;
};

// Some of a pool's environments, on one node at a time. It does what it is asked whatever becomes
// of the node: when that dies, drains or does not answer, it is made anew on another from its base,
// and what was asked of it since is repeated, without pictures, up to where it stood.
//
// On the nodes each such life, an epoch, is a pool of its own, and its stream goes with it: a node
// that comes back can answer for nothing that has moved.
//
// A thread of its own talks to the node. Threads: one call at a time, from any thread, the next
// after `done`; Look and what is const from any at any time.
class Shard {
 public:
  using Done = absl::AnyInvocable<void(absl::Status)>;

  // `number` is that of the shard in the life of its pool; `preferred_node`: where it is put if it
  // can be. Errors: RESOURCE_EXHAUSTED its thread cannot be started.
  static absl::StatusOr<std::unique_ptr<Shard>> Create(std::shared_ptr<const ShardTerms> terms,
                                                       int32_t number, Part range,
                                                       std::shared_ptr<const ShardBase> base,
                                                       std::string preferred_node);
  // Frees what it has on its node. REQUIRES: no call runs.
  ~Shard();
  Shard(const Shard&) = delete;
  Shard& operator=(const Shard&) = delete;

  const Part& range() const { return range_; }

  // Carries out all of the log up to `number`; `done` is called on its thread. Errors:
  // DEADLINE_EXCEEDED there was no node for FleetOptions::failover_timeout; those of nodes that
  // would come again elsewhere. After an error only Forget may follow.
  void Run(int64_t number, Done done);
  // What the node answered to `number`, of Run; until the next call.
  const procgen_client::Batch& answer() const { return answer_; }
  // Snapshots of environments, in the shard's numbers. Errors: as Run.
  void Save(std::vector<int32_t> environments, std::vector<std::string>* snapshots, Done done);
  // Has environments drawn, in the shard's numbers; `frames`: uint8 [size_px, size_px, 3],
  // one for each. Errors: as Run.
  void Render(std::vector<int32_t> environments, View view, int32_t size_px,
              std::vector<absl::Span<uint8_t>> frames, Done done);
  // Goes back to `number`, as if nothing after it had been carried out.
  void Forget(int64_t number);

  // Nodes have changed: it leaves one that is gone or drains, when it is not busy at once.
  void Look();

  // Where it begins anew. REQUIRES: no call runs.
  std::shared_ptr<const ShardBase> base() const { return base_; }
  // What is before it, this shard needs no more of the log.
  int64_t base_number() const { return base_number_; }
  // Where it is; empty: nowhere.
  std::string node_id() const;

 private:
  Shard(std::shared_ptr<const ShardTerms> terms, int32_t number, Part range,
        std::shared_ptr<const ShardBase> base, std::string preferred_node);

  // A pool on a node.
  struct Placement {
    FleetNodes::Seat seat;
    std::shared_ptr<NodeClient> node;
    std::string pool_id;
    std::string pool;
    std::shared_ptr<procgen_client::StepStream> stream;
  };
  struct Task {
    std::optional<int64_t> number;            // up to where the log is carried out; none: as it is
    absl::AnyInvocable<absl::Status()> work;  // and then this, which may be repeated; null: nothing
    Done done;
    absl::Time begin_time = SteadyNow();
  };

  void Start(Task task);
  void Loop();
  void GoBack(int64_t number);
  // Moves to another node if this one is not to be used any more.
  void Settle();
  // Does the task, whatever becomes of nodes.
  absl::Status Do(Task* task);
  // Brings the environments to where they are after `number`: once.
  absl::Status Reach(int64_t number);
  absl::Status Place();
  // Makes the pool on the node, and puts it into the states of the base.
  absl::Status Fill(Placement* placement);
  // Carries out an entry of the log, without pictures; ahead of its answer, if that can be.
  absl::Status Repeat(const LoggedRequest& logged);
  // Carries it out with all that it asks for, into answer_.
  absl::Status CarryOut(const LoggedRequest& logged);
  absl::Status PutStates(const LoggedRequest& logged);
  absl::Status ReceiveAll();
  // Snapshots of environments, in the shard's numbers; of all, if none is named.
  absl::StatusOr<std::vector<std::string>> FetchStates(
      absl::Span<const int32_t> environments) const;
  // Whether it has no node, and `why`; counts and logs when that changes.
  void SetWaits(bool waits, const absl::Status& why = absl::OkStatus());
  // As FleetNodes::Distrust, of the node where it is.
  absl::Status Distrust(const absl::Status& why) const;
  // An error of a call of the stream, whose client finds wrong answers, too.
  absl::Status StreamError(absl::Status status) const;
  // The node has failed to do something: lets go of it.
  void Lose(const absl::Status& why);
  void Leave();
  absl::Status TimeIsUp(const absl::Status& last) const;
  // Saves the states, if that is due; promotes what was saved, once that can be begun from.
  void SaveBase();
  void PromoteBase(int64_t number);
  bool Stops() const;
  std::string Environments() const;

  const std::shared_ptr<const ShardTerms> terms_;
  const int32_t number_;
  const Part range_;

  // Of its thread.
  std::string preferred_node_;
  int32_t epoch_ = 0;
  std::shared_ptr<const ShardBase> base_;
  std::optional<SavedBase> next_base_;  // not yet to be begun from
  int64_t save_position_ = 0;           // before which no states are saved, since that failed
  std::optional<Placement> placement_;
  bool waits_ = false;  // for a node
  // The last error would come again on any node, so that none is tried until something is asked.
  bool gives_up_ = false;
  int32_t unanswered_ = 0;                           // requests sent ahead
  int64_t position_ = 0;                             // of the log, of what is on the node
  int64_t asked_position_ = 0;                       // where it was asked to be
  std::shared_ptr<const v1::LevelSampler> sampler_;  // in force
  procgen_client::Batch answer_;
  // Answers to what is repeated, which nobody waits for. Apart, as that may happen while answer_ is
  // still to be read: a shard may lose its node when it is done and others are not.
  procgen_client::Batch repeated_;
  std::atomic<int64_t> base_number_;

  mutable absl::Mutex mutex_;
  std::optional<Task> task_ ABSL_GUARDED_BY(mutex_);
  bool looks_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<int64_t> forgets_ ABSL_GUARDED_BY(mutex_);  // all after this number
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  std::string node_id_ ABSL_GUARDED_BY(mutex_);  // of the placement
  std::shared_ptr<procgen_client::StepStream> stream_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;  // runs Loop
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_SHARD_H_
