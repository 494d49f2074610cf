#ifndef SERVER_POOL_POOL_SESSION_H_
#define SERVER_POOL_POOL_SESSION_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/pool/episodes/recent_episodes.h"
#include "server/pool/history/pool_history.h"
#include "server/pool/pool_context.h"
#include "server/pool/pool_observer.h"
#include "server/pool/pool_observers.h"
#include "server/pool/request.h"
#include "server/pool/request_executor.h"
#include "server/pool/request_pause.h"
#include "server/pool/request_times.h"
#include "server/pool/response_sink.h"
#include "server/pool/scene_capture.h"
#include "server/pool/session_options.h"
#include "server/pool/turn_queue.h"

namespace procgen {

// Mean return of one game of a pool.
struct GameReturn {
  std::string game;
  // Of its last RecentEpisodes::kRecentCount episodes among those listed; nullopt: there are none.
  std::optional<float> mean_return;
};

// A running pool: its environments, and their users. Its stream changes it; others look.
//
// Callers take turns, first come first served. A turn is one whole request of the stream, or one
// other call, which therefore sees the pool between two requests. Nothing blocks: turns begin in
// callbacks, and results arrive in callbacks.
//
// Threads: any method from any thread, except those under "In a turn", which only the caller with
// the turn may call.
class PoolSession {
 public:
  using Done = absl::AnyInvocable<void(absl::Status)>;
  // Asks the stream to end with this status. Called at most once, on any thread.
  using EndStream = absl::AnyInvocable<void(absl::Status)>;

  // `owner`: empty if callers are not authenticated. `context` must outlive this.
  PoolSession(std::string owner, std::string name, std::unique_ptr<Pool> pool,
              SessionOptions options, EndStream end_stream, const PoolContext& context);
  // REQUIRES: no caller has a turn.
  ~PoolSession() = default;
  PoolSession(const PoolSession&) = delete;
  PoolSession& operator=(const PoolSession&) = delete;

  const std::string& owner() const { return owner_; }
  const std::string& name() const { return name_; }
  const PoolOptions& options() const { return pool_->options(); }
  int32_t env_count() const { return options().env_count; }
  const SessionOptions& session_options() const { return session_options_; }
  Encoding encoding() const { return session_options_.encoding; }
  // Bytes of one environment's observation as drawn.
  int64_t observation_bytes() const {
    return static_cast<int64_t>(options().observation_format.bytes());
  }
  absl::Time create_time() const { return create_time_; }
  // Environment steps since it was created.
  int64_t step_count() const { return observers_.counts().step_count(); }
  // Statistics of its episodes and requests.
  RecentEpisodes::Summary episodes() const { return recent_episodes().Read(); }
  const RecentEpisodes& recent_episodes() const { return observers_.counts().episodes(); }
  // Mean returns of its games, in alphabetical order. Empty for a pool of one game.
  std::vector<GameReturn> ReadGameReturns() const;
  // Its statistics over time.
  PoolHistory& history() { return history_; }
  int64_t request_count() const { return executor_.request_count(); }
  RequestTimes::Summary request_times() const { return executor_.request_times(); }

  // Executes a request of the stream: waits while the pool is paused, takes a turn, validates the
  // request and lets the engine write into memory of `sink`. `request` and what its spans refer to
  // must stay valid until Done. Errors, which change nothing: those of TakeTurn; INVALID_ARGUMENT;
  // FAILED_PRECONDITION an environment must be reset; those of the pool.
  void Execute(Request* request, std::shared_ptr<ResponseSink> sink);

  // Asks the stream to end with `reason`, unless it was asked before. It answers the request that
  // is being executed.
  void End(const absl::Status& reason);
  // The stream is gone, or asked to end: its request does not wait for the end of a pause.
  void OnStreamEnds() { pause_.PassStream(); }
  // The stream has ended. Ends the observers. From now on no turn begins; callers get `reason`.
  void Close(const absl::Status& reason);

  // Pauses the pool: requests of its stream wait until each Pause was followed by EndPause, or
  // until the stream ends. StepPaused lets one pass.
  void Pause() { pause_.Pause(); }
  void EndPause() { pause_.EndPause(); }
  void StepPaused() { pause_.PassOne(); }
  bool paused() const { return pause_.paused(); }

  // As TurnQueue::Take and End.
  void TakeTurn(Done begin) { turns_.Take(std::move(begin)); }
  void EndTurn() { turns_.End(); }

  // Reports to `observer` what is drawn, and when the pool closes, until RemoveObserver. The
  // observer itself must not call RemoveObserver. Errors: the reason that observers were ended
  // with.
  absl::Status AddObserver(std::shared_ptr<PoolObserver> observer) {
    return observers_.AddObserver(std::move(observer));
  }
  void RemoveObserver(const PoolObserver* observer) { observers_.RemoveObserver(observer); }
  // Ends all observers and rejects new ones. The pool remains.
  void EndObservers(const absl::Status& reason) { observers_.EndObservers(reason); }

  // A number that changes whenever environments are stepped, reset or restored, or their level
  // sampler changes.
  int64_t change_number() const { return observers_.change_number(); }

  // In a turn, which the caller ends in `done`:

  // As those of Pool, on another thread. Memory that spans refer to must stay valid until `done`.
  using SavedStates = absl::AnyInvocable<void(absl::StatusOr<std::vector<std::string>>)>;
  void SaveStates(absl::Span<const int32_t> environments, SavedStates done);
  void RestoreStates(std::vector<StateToRestore> states, Done done);
  void CloneStates(std::vector<StateToClone> pairs, Done done);
  // Reads the recording of an episode of `environment`: the current one or the last that ended.
  // Calls `done`, which must keep the pool alive, once, on any thread. Errors: UNIMPLEMENTED no
  // history is kept; FAILED_PRECONDITION there is none.
  using EpisodeDone = absl::AnyInvocable<void(absl::StatusOr<EpisodeRecording>)>;
  void GetEpisode(int32_t environment, bool under_way, EpisodeDone done);
  // Returns an episode that ended. Errors: NOT_FOUND, UNIMPLEMENTED.
  absl::StatusOr<EpisodeRecording> FindEpisode(int32_t environment, uint64_t fingerprint) const;
  // As SceneCapture::Capture, on another thread if there are many.
  using Captured = absl::AnyInvocable<void(absl::StatusOr<Draw>)>;
  // As Pool::FindAgent, for environments of the pool.
  AgentPosition FindAgent(int32_t environment) { return pool_->FindAgent(environment).value(); }
  void CaptureScenes(std::vector<int32_t> environments, View view, int32_t size_px, Captured done);

  // Records that a capture ran from `begin_time` until now. Threads: this and next_capture_time
  // any, at any time.
  void NoteCapture(absl::Time begin_time);
  // When frame publishers may take the next turn to capture. Captures use at most 1 % of the pool's
  // time or, where one takes long, run once a second.
  absl::Time next_capture_time() const { return absl::FromUnixNanos(next_capture_ns_); }

 private:
  const std::string owner_;
  const std::string name_;
  const std::unique_ptr<Pool> pool_;
  const SessionOptions session_options_;
  const absl::Time create_time_;
  BackgroundExecutor* const background_;
  SceneCapture scene_capture_;
  PoolHistory history_;
  std::atomic<int64_t> next_capture_ns_ = 0;  // of next_capture_time()

  absl::Mutex mutex_;
  EndStream end_stream_ ABSL_GUARDED_BY(mutex_);  // null once called

  // Each may use the members before it.
  RequestPause pause_;
  TurnQueue turns_;
  PoolObservers observers_;
  RequestExecutor executor_;
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_SESSION_H_
