#ifndef SERVER_FLEET_POOL_FLEET_POOL_H_
#define SERVER_FLEET_POOL_FLEET_POOL_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/concurrency/background_executor.h"
#include "server/fleet/log/journal.h"
#include "server/fleet/log/pool_log.h"
#include "server/fleet/pool/rebalancer.h"
#include "server/fleet/pool/request_progress.h"
#include "server/fleet/pool/shard_context.h"
#include "server/fleet/pool/shard_set.h"
#include "server/fleet/pool/state_validator.h"
#include "server/session/backend/pool_backend.h"

namespace procgen {

// A pool in contiguous shards on the nodes of a fleet, which execute their parts of a request in
// parallel. Answers equal those of a single server, bit for bit, also after node failures (see
// Shard).
class FleetPool final : public PoolBackend {
 public:
  // `validator`: for the same options. `goes`: called at the start of the destructor. `executor`
  // must outlive this. Call Begin or Resume first.
  FleetPool(const PoolOptions& options, StateValidator validator, const ShardContext& context,
            BackgroundExecutor* executor, std::function<void(FleetPool*)> goes);
  ~FleetPool() override;

  // Creates the shards of a new pool on nodes. `threads`: reserved for its shards, one each.
  // Errors: those of Shard::Create and Shard::Run.
  void Begin(const std::vector<ShardAssignment>& assignments,
             std::vector<ShardThreadBudget::Reservation> threads, Done done);
  // Keeps a new pool, described by `pool`, in a file from now on. Errors: those of Journal::Create.
  absl::Status KeepIn(const std::string& path, const v1::Pool& pool);
  // Continues the pool of an earlier process and its file. Returns the last `answer_count` requests
  // or fewer, which must be executed again; the pool is in the state before the first of them.
  // Errors: those of ShardSet::Make.
  absl::StatusOr<std::vector<v1::StepPoolRequest>> Resume(const std::string& path,
                                                          const JournaledPool& journaled,
                                                          int64_t answer_count);
  // Moves shards from nodes that are gone or draining. A later request rebalances the pool if that
  // is worth it. Threads: any, at any time.
  void OnNodesChanged() { rebalancer_.OnNodesChanged(); }

  void Discard() override { log_.Discard(); }
  const PoolOptions& options() const override { return options_; }
  bool AwaitsReset(int32_t environment) const override {
    return awaits_reset_[static_cast<size_t>(environment)];
  }
  void BeginRequest(const Request& request, const Batch& first_part) override;
  void StepAsync(const StepInput& part, const Batch& batch, Done done) override;
  void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) override;
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) override;
  void RestoreStates(std::vector<StateToRestore> states, Done done) override;
  void CloneStates(std::vector<StateToClone> pairs, Done done) override;
  // The nodes draw immediately.
  void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                     CaptureDone done) override;

 private:
  // Runs the request on the shards that it concerns.
  void RunRequest(int64_t number);
  // Completes a part, if there is one.
  void AnswerPart(std::optional<RequestProgress::Answer> answer);
  void CopyRows(const Shard& shard, Part part, const Batch& batch);
  // Drops log entries that no checkpoint needs.
  void ForgetLog();
  // Validates states, logs them and applies them to the shards; on the background executor.
  void ApplyStates(std::vector<v1::State> states, const std::shared_ptr<Done>& done);

  const PoolOptions options_;
  StateValidator validator_;
  PoolLog log_;
  const std::shared_ptr<const ShardContext> context_;
  BackgroundExecutor* const executor_;
  const std::function<void(FleetPool*)> goes_;
  std::vector<bool> awaits_reset_;                   // [N]
  std::shared_ptr<const v1::LevelSampler> sampler_;  // in force; null: none
  // The one received from the learner, which counts as its owner's buffer; null: none.
  std::shared_ptr<const LevelSampler> held_sampler_;
  int64_t again_number_ = 0;  // of the last request that was executed again

  // The request under way.
  int64_t number_ = 0;      // in the log
  bool is_logged_ = false;  // by this execution
  RequestProgress progress_;

  ShardSet shards_;  // their threads use the members above
  Rebalancer rebalancer_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_FLEET_POOL_H_
