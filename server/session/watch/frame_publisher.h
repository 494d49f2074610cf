#ifndef SERVER_SESSION_WATCH_FRAME_PUBLISHER_H_
#define SERVER_SESSION_WATCH_FRAME_PUBLISHER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "server/concurrency/background_executor.h"
#include "server/concurrency/cpu_throttle.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/pool/pool_observer.h"
#include "server/session/pool/pool_session.h"
#include "server/session/watch/frame_subscriber.h"

namespace procgen {

// What one or several subscribers see of a pool: it is drawn once for all of them.
//
// When a frame set is due it is got the cheapest way. What the agent sees is copied from what is
// drawn for the learner, with the next request that shows it. Where no such request comes until the
// next frame set would be due, and at other sizes, the pool is captured in a turn, which takes
// some microseconds an environment, and drawn afterwards, by a thread that has whatever is left of
// the machine: where the learner goes on meanwhile and wants all of it, frame sets are left out.
// Where the pool has not changed, or nobody could send what would be drawn, nothing is. Threads:
// any method from any thread.
class FramePublisher final : public PoolObserver,
                             public std::enable_shared_from_this<FramePublisher> {
 public:
  // `drawing` must outlive this. It must be added to the pool's observers.
  FramePublisher(std::shared_ptr<PoolSession> pool, WatchSpec spec, FrameSetEncoder encode,
                 BackgroundExecutor* drawing);

  // Adds a subscriber; returns the frame set that is to be given to it, empty: the next Tick will
  // get one. None: the publisher has ended.
  std::optional<absl::Cord> Subscribe(std::shared_ptr<FrameSubscriber> subscriber)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether it was the last.
  bool Unsubscribe(const FrameSubscriber* subscriber) ABSL_LOCKS_EXCLUDED(mutex_);
  PoolSession& pool() const { return *pool_; }
  const WatchSpec& spec() const { return spec_; }

  // Gets a frame set if one is due; returns when the next one may be.
  absl::Time Tick(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  void OnPart(Part part, absl::Span<const uint8_t> observations) override;
  void OnRequestEnd(int64_t sequence_number, int64_t change_number) override;
  void OnInvalidated() override;
  void OnEnd(const absl::Status& reason) override;

 private:
  // Of a pool, as it stands between two requests.
  struct Numbers {
    int64_t sequence = -1;
    int64_t change = -1;

    bool operator==(const Numbers&) const = default;
  };

  Numbers NumbersNow() const;
  bool HasReadySubscriber() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Waits for what is drawn for the learner.
  void Arm() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Whether a turn is to be taken.
  bool BeginTick(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void OnTurn(const absl::Status& turn) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnCaptured(absl::StatusOr<PoolBackend::Draw> draw, absl::Time begin_time);
  // A frame set that has its numbers and no images yet.
  FrameSet BeginFrameSet() const;
  void Deliver(FrameSet frame_set) ABSL_LOCKS_EXCLUDED(mutex_);
  // Notes what a frame set after request `sequence_number` has taken.
  void Rest(int64_t sequence_number, const CpuThrottle& throttle) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::shared_ptr<PoolSession> pool_;
  const WatchSpec spec_;
  const FrameSetEncoder encode_;
  BackgroundExecutor* const drawing_;
  const bool can_copy_;  // observations are what the agent sees

  absl::Mutex mutex_;
  std::vector<std::shared_ptr<FrameSubscriber>> subscribers_ ABSL_GUARDED_BY(mutex_);
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time due_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time rests_until_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  bool at_once_ ABSL_GUARDED_BY(mutex_) = true;    // a subscriber has had nothing yet
  bool copy_came_ ABSL_GUARDED_BY(mutex_) = true;  // the last frame set was copied
  bool waits_for_turn_ ABSL_GUARDED_BY(mutex_) = false;
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;  // a frame set is drawn or encoded
  Numbers shown_ ABSL_GUARDED_BY(mutex_);      // of the last frame set, also if busy_
  absl::Cord latest_ ABSL_GUARDED_BY(mutex_);  // frame set, encoded
  // Of what is copied from the learner's observations.
  bool armed_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::string> copied_ ABSL_GUARDED_BY(mutex_);  // by place in the spec
  std::vector<bool> seen_ ABSL_GUARDED_BY(mutex_);           // likewise: it is as it stands
};

}  // namespace procgen

#endif  // SERVER_SESSION_WATCH_FRAME_PUBLISHER_H_
