#ifndef SERVER_SESSION_WATCH_POOL_VIEWS_H_
#define SERVER_SESSION_WATCH_POOL_VIEWS_H_

#include <map>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/concurrency/background_executor.h"
#include "server/concurrency/deadline_timer.h"
#include "server/session/pool/pool_session.h"
#include "server/session/watch/pool_view.h"
#include "server/session/watch/watcher.h"

namespace procgen {

// What is watched of all pools of a server: those who ask for the same see one view. One thread
// says when the next moments are due, and one draws them, with what the rest of the machine leaves.
// Threads: any method from any thread.
// Lock order: mutex_ before that of a PoolView, and before that of a pool's observers.
class PoolViews {
 public:
  PoolViews();
  PoolViews(const PoolViews&) = delete;
  PoolViews& operator=(const PoolViews&) = delete;

  // Begins to show `watcher` the pool, until Leave, which must be called also if it is told that
  // the watching ends. Errors: why that pool is not watched any more.
  absl::Status Watch(const std::shared_ptr<PoolSession>& pool, const WatchOrder& order,
                     const EncodeMoment& encode, const std::shared_ptr<Watcher>& watcher)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // A moment may still be on its way to it.
  void Leave(const Watcher* watcher) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Key = std::pair<const PoolSession*, WatchOrder>;

  absl::Time OnTimer(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Mutex mutex_;
  std::map<Key, std::shared_ptr<PoolView>> views_ ABSL_GUARDED_BY(mutex_);
  std::map<const Watcher*, std::shared_ptr<PoolView>> seen_by_ ABSL_GUARDED_BY(mutex_);

  // Last, so that their threads end before what they use.
  BackgroundExecutor drawing_{1};
  DeadlineTimer timer_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_WATCH_POOL_VIEWS_H_
