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

// A pool whose environments are on the nodes of a fleet, in contiguous shards, which execute their
// parts of a request at the same time. Answers equal those of a single server, bit for bit,
// whatever becomes of the nodes; Shard sees to that.
class FleetPool final : public PoolBackend {
 public:
  // `validator`: for the same options. `goes` is called when it begins to go. `executor` must
  // outlive it. Begin or Resume comes first.
  FleetPool(const PoolOptions& options, StateValidator validator, const ShardContext& context,
            BackgroundExecutor* executor, std::function<void(FleetPool*)> goes);
  ~FleetPool() override;

  // Makes a new one and puts all of it on nodes. `threads`: reserved for its shards, one each.
  // Errors: those of Shard::Create and Shard::Run.
  void Begin(const std::vector<ShardAssignment>& assignments,
             std::vector<ShardThreadBudget::Reservation> threads, Done done);
  // Keeps a new one, which is called so, in a file from now on. Errors: those of Journal::Create.
  absl::Status KeepIn(const std::string& path, const v1::Pool& pool);
  // Continues where another process had it, and keeps it there. It stands before the first of the
  // requests that are returned, the last `answer_count` ones or fewer, which are to be executed
  // again. Errors: those of ShardSet::Make.
  absl::StatusOr<std::vector<v1::StepPoolRequest>> Resume(const std::string& path,
                                                          const JournaledPool& journaled,
                                                          int64_t answer_count);
  // Shards leave nodes that are gone or drain; a later request rebalances the pool if that is worth
  // it. Threads: any, at any time.
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
  // The nodes draw at once.
  void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                     CaptureDone done) override;

 private:
  // Has the shards that a request concerns execute it.
  void RunRequest(int64_t number);
  // Answers a part if there is one.
  void AnswerPart(std::optional<RequestProgress::Answer> answer);
  void CopyRows(const Shard& shard, Part part, const Batch& batch);
  // Drops what no checkpoint needs from the log.
  void ForgetLog();
  // Validates states, logs them and has the shards apply them; on the background executor.
  void ApplyStates(std::vector<v1::State> states, const std::shared_ptr<Done>& done);

  const PoolOptions options_;
  StateValidator validator_;
  PoolLog log_;
  const std::shared_ptr<const ShardContext> context_;
  BackgroundExecutor* const executor_;
  const std::function<void(FleetPool*)> goes_;
  std::vector<bool> awaits_reset_;                   // [N]
  std::shared_ptr<const v1::LevelSampler> sampler_;  // in force; null: none
  // The one that the learner has sent, which counts among its owner's buffers; null: none.
  std::shared_ptr<const LevelSampler> held_sampler_;
  int64_t again_number_ = 0;  // of the last request that was executed again

  // Of the request that runs.
  int64_t number_ = 0;      // of the log
  bool is_logged_ = false;  // by this run of it
  RequestProgress progress_;

  ShardSet shards_;  // their threads use what is above
  Rebalancer rebalancer_;
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_FLEET_POOL_H_
