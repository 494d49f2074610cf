#ifndef SERVER_POOL_POOL_OBSERVERS_H_
#define SERVER_POOL_POOL_OBSERVERS_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "envcore/pool/pool.h"
#include "server/pool/episodes/episode_log.h"
#include "server/pool/pool_context.h"
#include "server/pool/pool_counts.h"
#include "server/pool/pool_observer.h"
#include "server/pool/request.h"

namespace procgen {

// All observers of a pool's batches other than the learner: statistics, episode history, and
// PoolObservers.
// Threads: methods that change something are called in a turn; those of observers from any thread.
class PoolObservers {
 public:
  // `context` must outlive this.
  PoolObservers(const PoolOptions& options, const PoolContext& context);

  // Appends the environments [first, first + count) whose last scenes an observer needs, in
  // increasing order.
  void SelectFinalScenes(int32_t first, int32_t count, std::vector<FinalScene>* selected)
      ABSL_LOCKS_EXCLUDED(observers_mutex_);
  // `request` was executed into `batch`, as BatchNumbers provides it.
  void OnExecuted(const Request& request, const StepInput& input, const Batch& batch,
                  int64_t request_count) ABSL_LOCKS_EXCLUDED(observers_mutex_);
  // States were restored; no observation of them exists yet.
  void OnRestore(const std::vector<StateToRestore>& states);
  void OnClone(const std::vector<StateToClone>& pairs);
  // Environments are about to change, or may have changed, outside of requests. What observers have
  // seen becomes invalid.
  void OnInvalidated() ABSL_LOCKS_EXCLUDED(observers_mutex_);
  // The next operation changes environments.
  void AddChange() { ++change_number_; }

  // As the methods of PoolSession.
  absl::Status AddObserver(std::shared_ptr<PoolObserver> observer)
      ABSL_LOCKS_EXCLUDED(observers_mutex_);
  void RemoveObserver(const PoolObserver* observer) ABSL_LOCKS_EXCLUDED(observers_mutex_);
  void EndObservers(const absl::Status& reason) ABSL_LOCKS_EXCLUDED(observers_mutex_);
  int64_t change_number() const { return change_number_; }

  const PoolCounts& counts() const { return counts_; }
  // Null: no history is kept.
  EpisodeLog* episodes() const { return episodes_.get(); }

 private:
  void UpdateFinalSceneEnvironments() ABSL_EXCLUSIVE_LOCKS_REQUIRED(observers_mutex_);

  std::atomic<int64_t>* const step_count_;  // of the server
  PoolCounts counts_;
  const std::unique_ptr<EpisodeLog> episodes_;
  std::atomic<int64_t> change_number_ = 0;

  absl::Mutex observers_mutex_;
  std::vector<std::shared_ptr<PoolObserver>> observers_ ABSL_GUARDED_BY(observers_mutex_);
  // Those of all observers, in increasing order.
  std::vector<int32_t> final_scene_environments_ ABSL_GUARDED_BY(observers_mutex_);
  absl::Status observers_end_ ABSL_GUARDED_BY(observers_mutex_);  // OK while they can be added
  std::atomic<bool> has_observers_ = false;                       // observers_ is not empty
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_OBSERVERS_H_
