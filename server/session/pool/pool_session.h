#ifndef SERVER_SESSION_POOL_POOL_SESSION_H_
#define SERVER_SESSION_POOL_POOL_SESSION_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/encoding/encoding.h"
#include "server/session/backend/observation_coding.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/backend/request.h"
#include "server/session/episodes/episode_log.h"
#include "server/session/episodes/recent_episodes.h"
#include "server/session/pool/attach_options.h"
#include "server/session/pool/pool_context.h"
#include "server/session/pool/pool_observer.h"
#include "server/session/pool/pool_observers.h"
#include "server/session/pool/request_executor.h"
#include "server/session/pool/request_pause.h"
#include "server/session/pool/request_times.h"
#include "server/session/pool/response_sink.h"
#include "server/session/pool/resume_buffer.h"
#include "server/session/pool/stream_slot.h"
#include "server/session/pool/turn_queue.h"
#include "server/shared_memory/shared_batch_slots.h"
#include "server/shared_memory/shared_memory_dir.h"

namespace procgen {

// A pool on the server. It consists of the attached stream (StreamSlot), turns (TurnQueue),
// execution (RequestExecutor), answers kept for resuming streams (ResumeBuffer), and observers
// (PoolObservers).
//
// Callers take turns, first come first served. A turn is one whole request of a stream, or one
// other call, which therefore sees the pool between two requests. Nothing blocks: turns begin in
// callbacks, and results arrive in callbacks.
//
// Threads: any method from any thread, except those under "In a turn", which only the caller with
// the turn may call.
class PoolSession {
 public:
  using EndStream = StreamSlot::EndStream;
  using Done = PoolBackend::Done;
  // Receives a snapshot of an environment. Returns false to stop.
  using TakeState = PoolBackend::TakeState;

  // `lease_duration`: lifetime without a stream, beginning now; infinite: until it is closed.
  // `shared_memory_dir`: where it shares memory with learners; null: it shares none. REQUIRES:
  // null, or `encoding` is kRaw.
  PoolSession(std::string owner, std::string name, std::unique_ptr<PoolBackend> backend,
              absl::Duration lease_duration, const PoolContext& context,
              Encoding encoding = Encoding::kRaw,
              const SharedMemoryDir* shared_memory_dir = nullptr);
  // REQUIRES: no caller has a turn.
  ~PoolSession();
  PoolSession(const PoolSession&) = delete;
  PoolSession& operator=(const PoolSession&) = delete;

  // The owner; empty if callers are not authenticated.
  const std::string& owner() const { return owner_; }
  const std::string& name() const { return name_; }
  const PoolOptions& options() const { return backend_->options(); }
  int32_t env_count() const { return backend_->env_count(); }
  // The encoding of its observations, and their size.
  const ObservationCoding& coding() const { return coding_; }
  // Bytes of one environment's observation as drawn.
  int64_t observation_bytes() const { return coding_.drawn_bytes(); }
  absl::Time create_time() const { return create_time_; }
  // Environment steps since it was created.
  int64_t step_count() const { return observers_.counts().step_count(); }
  // Statistics of its episodes and requests.
  RecentEpisodes::Summary episodes() const { return recent_episodes().Read(); }
  const RecentEpisodes& recent_episodes() const { return observers_.counts().episodes(); }
  RequestTimes::Summary request_times() const { return executor_.request_times(); }
  bool attached() const { return stream_.attached(); }
  bool closed() const { return stream_.closed(); }
  absl::Duration lease_duration() const { return stream_.lease_duration(); }
  // When the lease expires. InfiniteFuture while a stream is attached, and without a lease.
  absl::Time expire_time() const { return stream_.expire_time(); }
  // The number of the next new request.
  int64_t next_sequence_number() const { return executor_.next_sequence_number(); }
  // The lowest number with a kept answer; the next number if there is none.
  int64_t oldest_kept_sequence_number() const {
    return resume_buffer_.OldestOr(next_sequence_number());
  }

  // Continues the numbering of an earlier process. Call before the pool is used.
  void ResumeAt(int64_t next_sequence_number);

  // Attaches a stream and calls `done` once: on this thread or, after waiting for another stream to
  // detach, on that one's. Answers kept for earlier streams are dropped unless the stream is
  // resumable. Errors: FAILED_PRECONDITION another stream is attached and `take_over` is not set;
  // ABORTED a third stream took over; RESOURCE_EXHAUSTED the owner has too many streams, or no
  // memory for answers; the reason of Close.
  void Attach(const AttachOptions& options, EndStream end_stream, Done done);
  // Allocates shared memory for the attached stream, before its first turn. Calls `done` once: on
  // another thread or, if there is nothing to do, on this one. Errors: RESOURCE_EXHAUSTED.
  void ShareMemory(const AttachOptions& options, Done done);
  // The memory shared with learners; null: none. It has no batches until ShareMemory has succeeded.
  const SharedBatchSlots* shared_batch_slots() const { return shared_batch_slots_.get(); }
  // Detaches the stream. The waiting stream attaches, or the lease begins. REQUIRES: its turn has
  // ended.
  void Detach() {
    pause_.OnDetach();
    stream_.Detach();
  }
  // Ends the attached stream, if any, with `reason`. It detaches when its turn has ended.
  void End(StreamEnd why, const absl::Status& reason) { stream_.End(why, reason); }
  // Ends the stream. From now on no stream attaches and no turn begins; callers get `reason`.
  void Close(const absl::Status& reason);
  // As Close, because the pool cannot continue in this process; its data outside this process is
  // kept. Does nothing if the pool is closed.
  void Fail(const absl::Status& reason);
  // Closes the pool if its lease expired by `now`; otherwise returns false. A concurrent Attach or
  // Renew either succeeds or returns the error.
  bool CloseIfExpired(absl::Time now);
  // Restarts the lease, with a new duration if one is given. Errors: the reason of Close.
  absl::Status Renew(std::optional<absl::Duration> lease_duration) {
    return stream_.Renew(lease_duration);
  }

  // Executes a request of the stream: waits while the pool is paused, takes a turn, validates the
  // request, fills in its count, executes it part by part, keeps the answer if the stream is
  // resumable, and ends the turn. `request` and what its spans refer to must stay valid until
  // PartDone of the last part, or Done. Errors, which change nothing: those of TakeTurn;
  // INVALID_ARGUMENT; FAILED_PRECONDITION the answer is not kept, an environment must be reset, or
  // no shared-memory batch is free; those of the pool.
  void Execute(Request* request, std::shared_ptr<ResponseSink> sink);
  // Continues a request whose sink had no memory for its next part.
  void Resume() { executor_.Resume(); }

  // Pauses the pool: requests of its stream wait until each Pause was followed by EndPause, or
  // until the stream ends. StepPaused lets one pass.
  void Pause() { pause_.Pause(); }
  void EndPause() { pause_.EndPause(); }
  void StepPaused() { pause_.PassOne(); }
  bool paused() const { return pause_.paused(); }
  // The learner left: its stream ends, and its request does not wait for the end of a pause. The
  // request ends with CANCELLED unless it is still wanted.
  void OnLearnerGone() { pause_.PassStream(); }

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

  // In a turn:

  // As Execute, in the turn of the caller, which continues after the request: Done may begin the
  // next one. For requests that are not new ones of the stream: those of an earlier process,
  // executed `again`, and those without a number. REQUIRES: `sink` keeps the pool alive.
  void ExecuteInTurn(Request* request, std::shared_ptr<ResponseSink> sink) {
    executor_.ExecuteInTurn(request, std::move(sink));
  }
  // A number that changes whenever environments are stepped, reset or restored, or their level
  // sampler changes. Threads: any, at any time.
  int64_t change_number() const { return observers_.change_number(); }
  // Whether the episode of `environment` has ended and it must be reset before the next step.
  bool AwaitsReset(int32_t environment) const { return backend_->AwaitsReset(environment); }
  // Takes snapshots of `environments`, in order, on another thread, and passes each to `take` there
  // until it returns false. The span must stay valid until `done`. Errors: those of
  // Pool::SaveStates.
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done);
  // As those of Pool, on another thread. Memory that `states` refers to must stay valid until
  // `done`.
  void RestoreStates(std::vector<StateToRestore> states, Done done);
  void CloneStates(std::vector<StateToClone> pairs, Done done);
  // Reads the recording of an episode of `environment`: the current one or the last that ended.
  // Calls `done`, which must keep the pool alive, once, on any thread. Errors: UNIMPLEMENTED no
  // history is kept; FAILED_PRECONDITION there is none.
  using EpisodeDone = absl::AnyInvocable<void(absl::StatusOr<EpisodeRecording>)>;
  void GetEpisode(int32_t environment, bool under_way, EpisodeDone done);
  // Returns an episode that ended, in a turn. Errors: NOT_FOUND, UNIMPLEMENTED.
  absl::StatusOr<EpisodeRecording> FindEpisode(int32_t environment, uint64_t fingerprint) const;
  // As PoolBackend::CaptureScenes. The turn usually ends in `done`.
  void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                     PoolBackend::CaptureDone done);
  // Records that a capture ran from `begin_time` until now. Threads: this and next_capture_time
  // any, at any time.
  void NoteCapture(absl::Time begin_time);
  // When frame publishers may take the next turn to capture. Captures use at most 1 % of the pool's
  // time or, where one takes long, run once a second.
  absl::Time next_capture_time() const { return absl::FromUnixNanos(next_capture_ns_); }

 private:
  absl::Status GrowSharedBatchSlots(int32_t batch_count);
  // Notifies all parts of the close. REQUIRES: `stream_` is closed.
  void NotifyClosed(const absl::Status& reason);
  // Maximum bytes of one kept answer.
  int64_t AnswerBytesMax() const;

  const std::string owner_;
  const std::string name_;
  const std::unique_ptr<PoolBackend> backend_;
  const ObservationCoding coding_;
  const PoolContext context_;
  const absl::Time create_time_;
  // Grows while a stream attaches; written in turns of a stream. Null: no shared memory.
  const std::unique_ptr<SharedBatchSlots> shared_batch_slots_;
  std::atomic<int64_t> next_capture_ns_ = 0;  // of next_capture_time()

  // Each may use the members before it.
  RequestPause pause_;
  TurnQueue turns_;
  ResumeBuffer resume_buffer_;
  PoolObservers observers_;
  RequestExecutor executor_;
  StreamSlot stream_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_SESSION_H_
