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
#include "server/session/pool/request_times.h"
#include "server/session/pool/response_sink.h"
#include "server/session/pool/resume_buffer.h"
#include "server/session/pool/stream_slot.h"
#include "server/session/pool/turn_queue.h"
#include "server/shared_memory/shared_batch_slots.h"
#include "server/shared_memory/shared_folder.h"

namespace procgen {

// A pool on the server: which stream has it (StreamSlot), whose turn it is (TurnQueue), what it
// does (RequestExecutor), what is kept for streams that resume (ResumeBuffer), and what looks on
// (PoolObservers).
//
// Callers take turns: one at a time, in the order of asking. A turn is one whole request of a
// stream, or one call from beside it, so a call sees the pool between two requests. Nothing here
// blocks: a turn begins in a callback, and results arrive in callbacks.
//
// Threads: any method from any thread, but those under "In a turn" only by the caller that has the
// turn.
class PoolSession {
 public:
  using EndStream = StreamSlot::EndStream;
  using Done = PoolBackend::Done;
  // Calls that are handed a snapshot of an environment; false: no more are wanted.
  using TakeState = PoolBackend::TakeState;

  // `lease_duration`: how long it lives without a stream, beginning now; infinite: until it is
  // closed. `shared_folder`: where it shares memory with learners; null: it shares none, which is
  // REQUIRED unless `encoding` is kRaw.
  PoolSession(std::string owner, std::string name, std::unique_ptr<PoolBackend> backend,
              absl::Duration lease_duration, const PoolContext& context,
              Encoding encoding = Encoding::kRaw, const SharedFolder* shared_folder = nullptr);
  // REQUIRES: nobody has a turn.
  ~PoolSession();
  PoolSession(const PoolSession&) = delete;
  PoolSession& operator=(const PoolSession&) = delete;

  // Who made it; empty where callers are not asked who they are.
  const std::string& owner() const { return owner_; }
  const std::string& name() const { return name_; }
  const PoolOptions& options() const { return backend_->options(); }
  int32_t env_count() const { return backend_->env_count(); }
  // How its observations are sent, and what they take.
  const ObservationCoding& coding() const { return coding_; }
  // Bytes of one environment's observation, as it is drawn.
  int64_t observation_bytes() const { return coding_.drawn_bytes(); }
  absl::Time create_time() const { return create_time_; }
  // Environment steps since it was made.
  int64_t step_count() const { return observers_.counts().step_count(); }
  // How its episodes ended, and how long its requests took.
  RecentEpisodes::Summary episodes() const { return observers_.counts().episodes().Read(); }
  RequestTimes::Summary request_times() const { return executor_.request_times(); }
  bool attached() const { return stream_.attached(); }
  bool closed() const { return stream_.closed(); }
  absl::Duration lease_duration() const { return stream_.lease_duration(); }
  // When the lease runs out; InfiniteFuture while a stream is attached, and without a lease.
  absl::Time expire_time() const { return stream_.expire_time(); }
  // The number that the next new request must have.
  int64_t next_sequence_number() const { return executor_.next_sequence_number(); }
  // The least number of which the answer is kept; the next one if none is.
  int64_t oldest_kept_sequence_number() const {
    return resume_buffer_.OldestOr(next_sequence_number());
  }

  // Has it go on where another process had it, before it is used: with this number.
  void ResumeAt(int64_t next_sequence_number);

  // Takes the pool for a stream and calls `done` once, on this thread or, where it must wait for
  // another to detach, on that one's. What was kept for others is forgotten, unless the stream is
  // resumable. Errors: FAILED_PRECONDITION another stream has it, and is not to be taken over;
  // ABORTED a third one took over; RESOURCE_EXHAUSTED its owner has too many streams, or no memory
  // for answers; what it was closed with.
  void Attach(const AttachOptions& options, EndStream end_stream, Done done) {
    stream_.Attach(options, std::move(end_stream), std::move(done));
  }
  // Makes room in shared memory for the stream that has attached, before its first turn, and calls
  // `done` once, on another thread or, where there is nothing to do, on this one. Errors:
  // RESOURCE_EXHAUSTED.
  void ShareMemory(const AttachOptions& options, Done done);
  // What it shares with learners; null: nothing. Until ShareMemory has succeeded it has no batch.
  const SharedBatchSlots* shared_batch_slots() const { return shared_batch_slots_.get(); }
  // Gives it back: to the stream that takes over, or its lease begins. A turn must have ended.
  void Detach() { stream_.Detach(); }
  // Ends the stream, if one is attached, with `reason`; it detaches when its turn has ended.
  void End(StreamEnd why, const absl::Status& reason) { stream_.End(why, reason); }
  // Ends the stream, and lets none attach and no turn begin any more: those that ask are told.
  void Close(const absl::Status& reason);
  // As Close, because the pool cannot go on here: what is kept of it beyond this process stays. Of
  // a pool that is closed already nothing changes.
  void Fail(const absl::Status& reason);
  // Closes, if the lease has run out by `now`; false: it has not. One that attaches or renews at
  // the same time is either in time or told so.
  bool CloseIfExpired(absl::Time now);
  // Begins the lease anew, of another length if one is given. Errors: what it was closed with.
  absl::Status Renew(std::optional<absl::Duration> lease_duration) {
    return stream_.Renew(lease_duration);
  }

  // Executes a request of the stream: takes a turn, validates it, fills in its count, has the
  // environments carry it out part by part, keeps the answer of a resumable stream and ends the
  // turn. `request` and what its spans refer to must stay valid until PartDone of the last part, or
  // Done. Errors, which change nothing: those of TakeTurn; INVALID_ARGUMENT; FAILED_PRECONDITION an
  // answer that is not kept, an environment that must be reset, or no batch of shared memory that
  // is free; those of the pool.
  void Execute(Request* request, std::shared_ptr<ResponseSink> sink) {
    executor_.Execute(request, std::move(sink));
  }
  // Continues a request whose sink had no memory for its next part.
  void Resume() { executor_.Resume(); }

  // As TurnQueue::Take and End.
  void TakeTurn(Done begin) { turns_.Take(std::move(begin)); }
  void EndTurn() { turns_.End(); }

  // Has `observer` told what is drawn and that the pool closes, until RemoveObserver, which may not
  // be called by the observer. Errors: why observers are ended.
  absl::Status AddObserver(std::shared_ptr<PoolObserver> observer) {
    return observers_.AddObserver(std::move(observer));
  }
  void RemoveObserver(const PoolObserver* observer) { observers_.RemoveObserver(observer); }
  // Ends all observers, and lets none be added any more, while the pool remains.
  void EndObservers(const absl::Status& reason) { observers_.EndObservers(reason); }

  // In a turn:

  // As Execute, in the turn of the caller, which does not end with the request: Done may begin the
  // next one. It is no new request of the stream: one of an earlier process, executed `again`, or
  // one without a number. REQUIRES: `sink` keeps the pool alive.
  void ExecuteInTurn(Request* request, std::shared_ptr<ResponseSink> sink) {
    executor_.ExecuteInTurn(request, std::move(sink));
  }
  // A number that is another one whenever environments were stepped, reset or restored, or their
  // choice of levels changed. Threads: any, at any time.
  int64_t change_number() const { return observers_.change_number(); }
  // Whether the episode of `environment` has ended and it must be reset before it is stepped.
  bool AwaitsReset(int32_t environment) const { return backend_->AwaitsReset(environment); }
  // Takes snapshots of `environments`, in their order, on another thread, and hands each to `take`
  // there until no more are wanted. The span must stay valid until then. Errors: those of
  // Pool::SaveStates.
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done);
  // As those of Pool, on another thread. What the spans in `states` refer to must stay valid.
  void RestoreStates(std::vector<StateToRestore> states, Done done);
  void CloneStates(std::vector<StateToClone> pairs, Done done);
  // What happened in an episode of `environment`, the one under way or the last that ended. Calls
  // `done`, which must keep the pool alive, once, on any thread. Errors: UNIMPLEMENTED none are
  // remembered; FAILED_PRECONDITION there is none.
  using EpisodeDone = absl::AnyInvocable<void(absl::StatusOr<EpisodeRecording>)>;
  void GetEpisode(int32_t environment, bool under_way, EpisodeDone done);
  // As PoolBackend::CaptureScenes. `done` is where the turn ends, most often.
  void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                     PoolBackend::CaptureDone done);
  // Notes that capturing took until now. Threads: this and next_capture_time any, at any time.
  void NoteCapture(absl::Time begin_time);
  // When those who only watch may take the next turn for it: so that the pool stands still for them
  // 1 in 100 of its time at most, or, where capturing takes long, once a second.
  absl::Time next_capture_time() const { return absl::FromUnixNanos(next_capture_ns_); }

 private:
  absl::Status GrowSharedBatchSlots(int32_t batch_count);
  // Reports the close to all that it concerns. `stream_` must be closed.
  void TellClosed(const absl::Status& reason);
  // An answer of the pool, kept, has no more bytes.
  int64_t AnswerBytesMax() const;

  const std::string owner_;
  const std::string name_;
  const std::unique_ptr<PoolBackend> backend_;
  const ObservationCoding coding_;
  const PoolContext context_;
  const absl::Time create_time_;
  // Grown while a stream attaches, written in a turn of a stream. Null: it shares no memory.
  const std::unique_ptr<SharedBatchSlots> shared_batch_slots_;
  std::atomic<int64_t> next_capture_ns_ = 0;  // of next_capture_time()

  // Each may use those before it.
  TurnQueue turns_;
  ResumeBuffer resume_buffer_;
  PoolObservers observers_;
  RequestExecutor executor_;
  StreamSlot stream_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_POOL_SESSION_H_
