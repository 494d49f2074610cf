#ifndef SERVER_POOL_WATCH_FRAME_PUBLISHERS_H_
#define SERVER_POOL_WATCH_FRAME_PUBLISHERS_H_

#include <map>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "server/concurrency/background_executor.h"
#include "server/concurrency/deadline_timer.h"
#include "server/pool/pool_session.h"
#include "server/pool/watch/frame_publisher.h"
#include "server/pool/watch/frame_subscriber.h"

namespace procgen {

// The frame publishers of all pools of a server. Identical subscriptions share one. One thread
// schedules frame sets, and one low-priority thread draws them.
// Threads: any method from any thread.
// Lock order: mutex_ before that of a FramePublisher, and before that of a pool's observers.
class FramePublishers {
 public:
  FramePublishers();
  FramePublishers(const FramePublishers&) = delete;
  FramePublishers& operator=(const FramePublishers&) = delete;

  // Shows the pool to `subscriber` until Unsubscribe, which must be called even after
  // FrameSubscriber::End. Errors: why the pool cannot be watched.
  absl::Status Subscribe(const std::shared_ptr<PoolSession>& pool, const WatchSpec& spec,
                         const FrameSetEncoder& encode,
                         const std::shared_ptr<FrameSubscriber>& subscriber)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends a subscription. A frame set may still arrive during the call.
  void Unsubscribe(const FrameSubscriber* subscriber) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Key = std::pair<const PoolSession*, WatchSpec>;

  absl::Time OnTimer(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Mutex mutex_;
  std::map<Key, std::shared_ptr<FramePublisher>> publishers_ ABSL_GUARDED_BY(mutex_);
  std::map<const FrameSubscriber*, std::shared_ptr<FramePublisher>> publisher_of_
      ABSL_GUARDED_BY(mutex_);

  // Last, so that their threads end before the members that they use.
  BackgroundExecutor drawing_{1};
  DeadlineTimer timer_;
};

}  // namespace procgen

#endif  // SERVER_POOL_WATCH_FRAME_PUBLISHERS_H_
