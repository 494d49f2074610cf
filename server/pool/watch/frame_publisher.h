#ifndef SERVER_POOL_WATCH_FRAME_PUBLISHER_H_
#define SERVER_POOL_WATCH_FRAME_PUBLISHER_H_

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
#include "server/pool/pool_observer.h"
#include "server/pool/pool_session.h"
#include "server/pool/watch/frame_subscriber.h"

namespace procgen {

// Produces the frame sets of one WatchSpec of a pool, for all its subscribers.
//
// A due frame set is taken from the cheapest source. The agent's view is copied from the learner's
// observations, with the next request that contains them. If no such request arrives before the
// next frame set is due, and at other sizes, the pool is captured in a turn (a few us per
// environment). A low-priority thread draws it afterwards. If that competes with the learner for
// cores, frame sets are skipped. Nothing is drawn if the pool has not changed or no subscriber can
// send.
//
// When an episode ends, its last scene is captured within the step. The next frame set shows it in
// place of the current state, and the one after it shows the current state.
// Threads: any method from any thread.
class FramePublisher final : public PoolObserver,
                             public std::enable_shared_from_this<FramePublisher> {
 public:
  // `drawing` must outlive this. Must be added to the pool's observers.
  FramePublisher(std::shared_ptr<PoolSession> pool, WatchSpec spec, FrameSetEncoder encode,
                 BackgroundExecutor* drawing);

  // Adds a subscriber. Returns the frame set to give to it; empty if the next Tick produces one;
  // nullopt if the publisher has ended.
  std::optional<absl::Cord> Subscribe(std::shared_ptr<FrameSubscriber> subscriber)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether it was the last subscriber.
  bool Unsubscribe(const FrameSubscriber* subscriber) ABSL_LOCKS_EXCLUDED(mutex_);
  PoolSession& pool() const { return *pool_; }
  const WatchSpec& spec() const { return spec_; }

  // Produces a frame set if one is due. Returns when the next may be due.
  absl::Time Tick(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Span<const int32_t> final_scene_environments() const override { return spec_.environments; }
  void OnExecuted(const Request& request, const StepInput& input, const Batch& batch,
                  int64_t request_count, int64_t change_number) override
      ABSL_LOCKS_EXCLUDED(mutex_);
  void OnInvalidated() override;
  void OnEnd(const absl::Status& reason) override;

 private:
  // Numbers of a pool's state between two requests.
  struct Numbers {
    int64_t request_count = -1;
    int64_t change = -1;

    bool operator==(const Numbers&) const = default;
  };

  // An episode whose end is not shown yet.
  struct Ending {
    FinishedEpisode episode;
    EnvironmentStep last_step;
    std::shared_ptr<const SceneSnapshot> scene;
  };
  // A frame set without images of the current state, and the scenes of those that show an end.
  struct Plan {
    FrameSet frame_set;
    std::vector<std::shared_ptr<const SceneSnapshot>> final_scenes;  // null: the current state
  };

  Numbers NumbersNow() const;
  bool HasReadySubscriber() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Starts copying from the learner's observations.
  void Arm() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns whether to take a turn.
  bool BeginTick(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void OnTurn(const absl::Status& turn) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnCaptured(absl::StatusOr<Draw> draw, absl::Time begin_time);
  Plan BeginFrameSet(int64_t request_count) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CopyObservation(size_t i, size_t row, const StepInput& input, const Batch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Takes what is needed of the environments of `input`.
  void Note(const Request& request, const StepInput& input, const Batch& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Remembers the newest step of an environment.
  void NoteStep(size_t i, size_t row, const Request& request, const StepInput& input,
                const Batch& batch) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Remembers the end of an episode, if its last scene was captured. `last_step`: null if steps are
  // not needed.
  void NoteEnd(size_t i, size_t row, const Batch& batch, const EnvironmentStep* last_step)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Draws the last states of ended episodes over the current ones.
  static void DrawFinalScenes(Plan* plan);
  void Deliver(FrameSet frame_set) ABSL_LOCKS_EXCLUDED(mutex_);
  // Rests according to the CPU time of the frame set after request `request_count`.
  void Rest(int64_t request_count, const CpuThrottle& throttle) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::shared_ptr<PoolSession> pool_;
  const WatchSpec spec_;
  const FrameSetEncoder encode_;
  BackgroundExecutor* const drawing_;
  const bool can_copy_;  // observations are the agent's view

  absl::Mutex mutex_;
  std::vector<std::shared_ptr<FrameSubscriber>> subscribers_ ABSL_GUARDED_BY(mutex_);
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time due_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time rests_until_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  bool at_once_ ABSL_GUARDED_BY(mutex_) = true;    // a subscriber has received nothing yet
  bool copy_came_ ABSL_GUARDED_BY(mutex_) = true;  // the last frame set was copied
  bool waits_for_turn_ ABSL_GUARDED_BY(mutex_) = false;
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;  // a frame set is drawn or encoded
  Numbers shown_ ABSL_GUARDED_BY(mutex_);      // of the last frame set, also while busy_
  absl::Cord latest_ ABSL_GUARDED_BY(mutex_);  // frame set, encoded
  // By index in the spec: the newest end that is not shown yet, and whether the last frame set
  // showed one.
  std::vector<std::optional<Ending>> endings_ ABSL_GUARDED_BY(mutex_);
  std::vector<bool> showed_end_ ABSL_GUARDED_BY(mutex_);
  // By index in the spec, if it asks for steps.
  std::vector<std::optional<EnvironmentStep>> steps_ ABSL_GUARDED_BY(mutex_);
  // Copying from the learner's observations.
  bool armed_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::string> copied_ ABSL_GUARDED_BY(mutex_);  // by index in the spec
  std::vector<bool> seen_ ABSL_GUARDED_BY(mutex_);           // likewise: the copy is current
};

}  // namespace procgen

#endif  // SERVER_POOL_WATCH_FRAME_PUBLISHER_H_
