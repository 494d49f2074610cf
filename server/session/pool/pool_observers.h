#ifndef SERVER_SESSION_POOL_POOL_OBSERVERS_H_
#define SERVER_SESSION_POOL_POOL_OBSERVERS_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "envcore/pool/pool.h"
#include "server/session/backend/request.h"
#include "server/session/episodes/episode_log.h"
#include "server/session/pool/pool_context.h"
#include "server/session/pool/pool_counts.h"
#include "server/session/pool/pool_observer.h"

namespace procgen {

// All that looks at a pool's batches beside its learner: statistics, the history of episodes, and
// observers.
// Threads: methods that change something are called in a turn, but those of observers from any
// thread.
class PoolObservers {
 public:
  // `context` must outlive this.
  PoolObservers(const PoolOptions& options, const PoolContext& context);

  // A part of `request` was executed into `batch`, as BatchNumbers lends it; or failed, and with it
  // the whole request. `request_number`: its sequence number.
  void OnPart(const Request& request, const StepInput& input, const Batch& batch, bool ok);
  // States were restored: nobody has seen them.
  void OnRestore(const std::vector<StateToRestore>& states);
  void OnClone(const std::vector<StateToClone>& pairs);
  // They are about to be, or may have been, changed past requests, and with
  // them what observers have seen.
  void OnInvalidated() ABSL_LOCKS_EXCLUDED(observers_mutex_);
  // An earlier process executed the requests before; what happened in them is not known.
  void ForgetEpisodes(int32_t env_count);
  // Environments are changed by what comes next.
  void AddChange() { ++change_number_; }

  // As those of PoolSession.
  absl::Status AddObserver(std::shared_ptr<PoolObserver> observer)
      ABSL_LOCKS_EXCLUDED(observers_mutex_);
  void RemoveObserver(const PoolObserver* observer) ABSL_LOCKS_EXCLUDED(observers_mutex_);
  void EndObservers(const absl::Status& reason) ABSL_LOCKS_EXCLUDED(observers_mutex_);
  int64_t change_number() const { return change_number_; }

  const PoolCounts& counts() const { return counts_; }
  // Null: none are remembered.
  EpisodeLog* episodes() const { return episodes_.get(); }

 private:
  void Remember(const Request& request, const StepInput& input, const Batch& batch, bool ok);
  void NotifyObservers(const Request& request, Part part, const Batch& batch, bool ok)
      ABSL_LOCKS_EXCLUDED(observers_mutex_);

  std::atomic<int64_t>* const step_count_;  // of the server
  PoolCounts counts_;
  const std::unique_ptr<EpisodeLog> episodes_;
  std::atomic<int64_t> change_number_ = 0;

  absl::Mutex observers_mutex_;
  std::vector<std::shared_ptr<PoolObserver>> observers_ ABSL_GUARDED_BY(observers_mutex_);
  absl::Status observers_end_ ABSL_GUARDED_BY(observers_mutex_);  // OK while they may be added
  std::atomic<bool> has_observers_ = false;                       // observers_ has some
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_OBSERVERS_H_
