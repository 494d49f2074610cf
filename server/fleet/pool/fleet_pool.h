#ifndef SERVER_FLEET_POOL_FLEET_POOL_H_
#define SERVER_FLEET_POOL_FLEET_POOL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/concurrency/background_executor.h"
#include "server/fleet/log/journal.h"
#include "server/fleet/log/request_log.h"
#include "server/fleet/pool/shard.h"
#include "server/session/backend/pool_backend.h"

namespace procgen {

// A pool whose environments are on the nodes of a fleet: contiguous shards, which step what
// concerns them at the same time. What it answers is what one server would, to the last bit,
// whatever becomes of the nodes; Shard sees to that.
class FleetPool final : public PoolBackend {
 public:
  // Checks all that Pool::Create would, in the same words. Errors: those of Pool::Create.
  static absl::StatusOr<std::unique_ptr<Pool>> Check(const PoolOptions& options);

  // `model`: of Check, to try states on. `goes` is called when it begins to go. `executor` must
  // outlive it. Begin or Resume comes first.
  FleetPool(const PoolOptions& options, std::unique_ptr<Pool> model, const ShardTerms& terms,
            BackgroundExecutor* executor, std::function<void(FleetPool*)> goes);
  ~FleetPool() override;

  // Makes a new one and puts all of it on nodes. Errors: those of Shard::Run.
  void Begin(const std::vector<FleetNodes::Share>& shares, Done done);
  // Keeps a new one, which is called so, in a file from now on. Errors: those of Journal::Create.
  absl::Status KeepIn(const std::string& path, const v1::Pool& pool);
  // Goes on where another process had it, and keeps it there. It stands before the first of the
  // requests that are returned, the last `answer_count` ones or fewer, which are to be carried out
  // again. Errors: those of MakeShards.
  absl::StatusOr<std::vector<v1::StepPoolRequest>> Resume(const std::string& path,
                                                          const JournaledPool& journaled,
                                                          int64_t answer_count);
  // Nodes may have changed: looks whether another division would be worth it, which the next
  // request then brings about. Threads: any, at any time.
  void Look();

  void Discard() override;
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
  enum class Progress : uint8_t { kUntouched, kRunning, kDone };

  // Environments of one shard, in its numbers, and where they stand in a list of the pool's.
  struct Chosen {
    std::vector<int32_t> environments;
    std::vector<size_t> places;
  };

  // Whether so much would move that it is worth it.
  bool IsWorthDividing(const std::vector<FleetNodes::Share>& now) const;
  // Saves all states, then divides if that is all that it takes, and then runs `number`.
  void BeginDivision(int64_t number);
  // Whether what was saved for a division is enough to begin from, at `number`.
  bool CanDivide(int64_t number);
  // Puts other shards in place of these, which begin with the states of `base`. On the background
  // executor.
  void Divide(const ShardBase& base);
  // A shard for each of `bases`; `nodes`: where they are put if they can be, in the same order.
  // Errors: as Shard::Create.
  absl::StatusOr<std::vector<std::unique_ptr<Shard>>> MakeShards(
      const ShardBases& bases, const std::vector<std::string>& nodes);
  void SetShards(std::vector<std::unique_ptr<Shard>> shards) ABSL_LOCKS_EXCLUDED(shards_mutex_);
  // Adds to the log, or takes back what was added last.
  int64_t Log(LoggedRequest logged);
  void TakeBackLogged();
  // Has the shards that a request concerns carry it out.
  void RunRequest(int64_t number);
  // Whether the log has room for another entry; `may_shorten`: one that may make it shorter.
  absl::Status CheckLog(bool may_shorten) const;
  size_t ShardOf(int32_t environment) const;
  absl::Status CheckIndex(int32_t environment) const;
  void RunShards(int64_t number, const std::function<bool(const Shard&)>& concerns);
  void OnShardDone(size_t shard, const absl::Status& status);
  // Answers the part that waits, if all that it waits for is there.
  void AnswerPart();
  bool CanAnswerLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CopyRows(const Shard& shard, Part part, const Batch& batch);
  void ForgetLog();
  // By shard.
  std::vector<Chosen> Choose(absl::Span<const int32_t> environments) const;
  // Gets snapshots, in the order of `environments`.
  void Gather(const std::vector<int32_t>& environments,
              std::function<void(absl::StatusOr<std::vector<std::string>>)> done);
  // Checks states and puts them in; on the background executor.
  void Put(std::vector<v1::State> states, const std::shared_ptr<Done>& done);
  absl::Status CheckStates(const std::vector<v1::State>& states);

  const PoolOptions options_;
  const std::unique_ptr<Pool> model_;  // an environment of each game, to try states on
  const std::shared_ptr<const ShardTerms> terms_;
  BackgroundExecutor* const executor_;
  const std::function<void(FleetPool*)> goes_;
  RequestLog log_;
  std::vector<bool> awaits_reset_;                   // [N]
  std::shared_ptr<const v1::LevelSampler> sampler_;  // in force; null: none
  // The one that the learner has sent, which counts among its owner's buffers; null: none.
  std::shared_ptr<const LevelSampler> held_sampler_;
  std::unique_ptr<Journal> journal_;            // null: it is not kept
  int64_t again_number_ = 0;                    // of the last request that was repeated
  int32_t shard_number_ = 0;                    // of the last shard that was made
  std::optional<SavedBase> division_;           // all states at one moment, to divide from
  std::vector<std::unique_ptr<Shard>> shards_;  // changed under shards_mutex_

  absl::Mutex shards_mutex_;  // of who changes them, and who looks on without having the turn
  int32_t looks_worth_dividing_ ABSL_GUARDED_BY(shards_mutex_) = 0;  // one after the other
  std::atomic<bool> divides_ = false;                                // with the next request

  absl::Mutex mutex_;
  // Of what runs.
  int64_t number_ ABSL_GUARDED_BY(mutex_) = 0;      // of the log
  bool is_logged_ ABSL_GUARDED_BY(mutex_) = false;  // by this run of it
  Part request_ ABSL_GUARDED_BY(mutex_);
  std::vector<Progress> progress_ ABSL_GUARDED_BY(mutex_);  // by shard
  int32_t running_count_ ABSL_GUARDED_BY(mutex_) = 0;
  // Shards have begun; until then there may be others, or none while the pool is divided.
  bool is_running_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);  // the first error
  Part part_ ABSL_GUARDED_BY(mutex_);
  Batch batch_ ABSL_GUARDED_BY(mutex_);
  Done part_done_ ABSL_GUARDED_BY(mutex_);  // null: no part waits
};

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_FLEET_POOL_H_
