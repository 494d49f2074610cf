#ifndef SERVER_SESSION_POOL_SESSION_H_
#define SERVER_SESSION_POOL_SESSION_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "server/metrics/metrics.h"
#include "server/session/alarm.h"
#include "server/session/background_executor.h"
#include "server/session/byte_budget.h"
#include "server/session/episode_log.h"
#include "server/session/hosted_pool.h"
#include "server/session/kept_answers.h"
#include "server/session/limits.h"
#include "server/session/observation_coding.h"
#include "server/session/owners.h"
#include "server/session/pool_counts.h"
#include "server/session/pool_tap.h"
#include "server/session/recent_episodes.h"
#include "server/session/request.h"
#include "server/session/request_times.h"
#include "server/shared_memory/batch_ledger.h"
#include "server/shared_memory/shared_folder.h"
#include "server/shared_memory/shared_ring.h"

namespace procgen {

// How many may wait for their turn at one pool.
inline constexpr size_t kTurnsWaitingMax = 64;

// What all pools of a server share. All of it must outlive them.
struct PoolSurroundings {
  Owners* owners = nullptr;
  BackgroundExecutor* executor = nullptr;
  Alarm* lease_alarm = nullptr;                // also tells the time
  ByteBudget* kept_answer_bytes = nullptr;     // for the answers that they keep
  ByteBudget* shared_memory_bytes = nullptr;   // for what they share with learners
  ByteBudget* episode_bytes = nullptr;         // for the episodes that they remember
  std::atomic<int64_t>* step_count = nullptr;  // environment steps are added to it
  Metrics* metrics = nullptr;                  // and all else that is counted to these
};

// How a stream wants a pool.
struct AttachOptions {
  int32_t requests_in_flight_max = kRequestsInFlightDefault;  // it has no more unanswered
  bool resumable = false;  // the answers to that many are kept, also beyond its end
  bool take_over = false;  // if another stream has the pool, it ends
  // What the caller can do if another stream has the pool, for the error.
  const char* when_attached = "end that one, or attach with take_over";
  // Of a pool that shares memory: how many batches its learner may hold besides those of unanswered
  // requests, and which ones of earlier streams it still holds.
  int32_t held_batches_max = 0;
  std::vector<int32_t> held_batches = {};
};

// Why a stream must end.
enum class StreamEnd : uint8_t {
  kDrain,      // the server will stop
  kTakenOver,  // another stream waits for the pool
  kClosed,     // the pool is gone
};

// A pool on the server: its name, who has its stream, and whose turn it is.
//
// Whoever wants something of the pool takes turns: one at a time, in the order of asking. A turn is
// one whole request of a stream, or one call from beside it, so a call sees the pool between two
// requests. Nothing here blocks: a turn begins in a callback, and so do results arrive.
//
// Threads: any method from any thread, but those under "In a turn" only by who has the turn.
class PoolSession {
 public:
  // Calls that tell a stream that it must end, and with what; called once at most, and not after
  // Detach.
  using EndStream = absl::AnyInvocable<void(StreamEnd, absl::Status)>;
  using Done = HostedPool::Done;
  using NearEnd = HostedPool::NearEnd;
  // Calls that are handed a snapshot of an environment; false: no more are wanted.
  using TakeState = HostedPool::TakeState;

  // `lease_duration`: how long it lives without a stream, beginning now; infinite: until it is
  // closed. `compression`: of the observations; none: they are sent as they are drawn.
  // `shared_folder`: where it shares memory with learners; null: it shares none. REQUIRES: at most
  // one of the two.
  PoolSession(std::string owner, std::string name, std::unique_ptr<HostedPool> pool,
              absl::Duration lease_duration, const PoolSurroundings& surroundings,
              std::optional<Compression> compression = std::nullopt,
              const SharedFolder* shared_folder = nullptr);
  // REQUIRES: nobody has a turn.
  ~PoolSession();
  PoolSession(const PoolSession&) = delete;
  PoolSession& operator=(const PoolSession&) = delete;

  // Who made it; empty where callers are not asked who they are.
  const std::string& owner() const { return owner_; }
  const std::string& name() const { return name_; }
  const PoolOptions& options() const { return pool_->options(); }
  int32_t env_count() const { return pool_->env_count(); }
  // How its observations are sent, and what they take.
  const ObservationCoding& coding() const { return coding_; }
  // Bytes of one environment's observation, as it is drawn.
  int64_t observation_bytes() const { return coding_.drawn_bytes(); }
  absl::Time create_time() const { return create_time_; }
  // Environment steps since it was made.
  int64_t step_count() const { return counts_.step_count(); }
  // How its episodes ended, and how long its requests took.
  RecentEpisodes::Summary episodes() const { return counts_.episodes().Read(); }
  RequestTimes::Summary request_times() const { return request_times_.Read(); }
  bool attached() const;
  bool closed() const;
  absl::Duration lease_duration() const;
  // When the lease runs out; InfiniteFuture while a stream is attached, and without a lease.
  absl::Time expire_time() const;
  // The number that the next new request must bear.
  int64_t next_sequence_number() const { return next_sequence_number_; }
  // The least number of which the answer is kept; the next one if none is.
  int64_t oldest_kept_sequence_number() const;

  // Has it go on where another process had it, before it is used: with this number.
  void ResumeAt(int64_t next_sequence_number);

  // Takes the pool for a stream and calls `done` once, on this thread or, where it must wait for
  // another to detach, on that one's. What was kept for others is forgotten, unless the stream is
  // resumable. Errors: FAILED_PRECONDITION another stream has it, and is not to be taken over;
  // ABORTED a third one took over; RESOURCE_EXHAUSTED its owner has too many streams, or no memory
  // for answers; what it was closed with.
  void Attach(const AttachOptions& options, EndStream end_stream, Done done);
  // Makes room in shared memory for the stream that has attached, before its first turn, and calls
  // `done` once, on another thread or, where there is nothing to do, on this one. Errors:
  // RESOURCE_EXHAUSTED.
  void ShareMemory(const AttachOptions& options, Done done);
  // What it shares with learners; null: nothing. Until ShareMemory has succeeded it has no batch.
  const SharedRing* shared_ring() const { return shared_ring_.get(); }
  // Gives it back: to the stream that takes over, or its lease begins. A turn must have ended.
  void Detach();
  // Ends the stream, if one is attached, with `reason`; it detaches when its turn has ended.
  void End(StreamEnd why, const absl::Status& reason);
  // Ends the stream, and lets none attach and no turn begin any more: those that ask are told.
  void Close(const absl::Status& reason);
  // As Close, because the pool cannot go on here: what is kept of it beyond this process stays. Of
  // a pool that is closed already nothing changes.
  void Fail(const absl::Status& reason);
  // Closes, if the lease has run out by `now`; false: it has not. One that attaches or renews at
  // the same time is either in time or told so.
  bool CloseIfExpired(absl::Time now);
  // Begins the lease anew, of another length if one is given. Errors: what it was closed with.
  absl::Status Renew(std::optional<absl::Duration> lease_duration);

  // Calls `begin` with OK when it is the caller's turn (on this thread, or one that ends a turn),
  // who then must call EndTurn once; or with an error, and it has no turn: after Close, its reason;
  // RESOURCE_EXHAUSTED kTurnsWaitingMax others wait.
  void TakeTurn(Done begin);
  void EndTurn();

  // Has `tap` told what is drawn and that the pool closes, until RemoveTap, which may not be called
  // by the tap. Errors: why taps are ended.
  absl::Status AddTap(std::shared_ptr<PoolTap> tap) ABSL_LOCKS_EXCLUDED(taps_mutex_);
  void RemoveTap(const PoolTap* tap) ABSL_LOCKS_EXCLUDED(taps_mutex_);
  // Ends all taps, and lets none be added any more, while the pool goes on.
  void EndTaps(const absl::Status& reason) ABSL_LOCKS_EXCLUDED(taps_mutex_);

  // In a turn:

  // Checks a request of the stream, fills in its count, and takes it: its number counts as used.
  // One with a number that was used before is not to be carried out: its answer is returned.
  // Errors, which take nothing: INVALID_ARGUMENT; FAILED_PRECONDITION an answer that is not kept,
  // an environment that must be reset, or no batch of shared memory that is free.
  absl::StatusOr<std::optional<Answer>> Accept(Request* request);
  // Keeps the answer to an accepted request of a resumable stream.
  void Keep(int64_t sequence_number, Answer answer);
  // Carries out a part of an accepted request (kSample: all of it). Returns soon; `done` is
  // called once, on any thread, also on this one before this returns (HostedPool); with an error
  // the whole request has changed nothing, and its number is the next again. `request` and the
  // memory of `batch` must stay valid until then. `near_end`: as that of Pool::StepAsync.
  void RunPart(const Request& request, Part part, const Batch& batch, Done done,
               NearEnd near_end = nullptr);
  // Notes that a request was carried out, and how long that took since it arrived.
  void AddRequestTime(absl::Duration duration) { request_times_.Add(duration); }
  // A number that is another one whenever environments were stepped, reset or restored, or their
  // choice of levels changed. Threads: any, at any time.
  int64_t change_number() const { return change_number_; }
  // Whether the episode of `environment` has ended and it must be reset before it is stepped.
  bool AwaitsReset(int32_t environment) const { return pool_->AwaitsReset(environment); }
  // Takes snapshots of `environments`, in their order, on another thread, and hands each to `take`
  // there until no more are wanted. The span must stay valid until then. Errors: those of
  // Pool::SaveStates.
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done);
  // As those of Pool, on another thread. What the spans in `states` refer to must stay valid.
  void RestoreStates(std::vector<StateToRestore> states, Done done);
  void CloneStates(std::vector<StateToClone> pairs, Done done);
  // What happened in an episode of `environment`, the one under way or the last that ended. Calls
  // `done` once, on any thread. Errors: UNIMPLEMENTED none are remembered; FAILED_PRECONDITION
  // there is none.
  using EpisodeDone = absl::AnyInvocable<void(absl::StatusOr<EpisodeRecording>)>;
  void ReadEpisode(int32_t environment, bool under_way, EpisodeDone done);
  // As HostedPool::Look. `done` is where the turn ends, most often.
  void Look(const std::vector<int32_t>& environments, View view, int32_t side_px,
            HostedPool::LookDone done);
  // Notes that looking took until now. Threads: this and looks_from any, at any time.
  void NoteLook(absl::Time begin_time);
  // When those who only watch may take the next turn for it: so that the pool stands still for them
  // 1 in 100 of its time at most, or, where looking takes long, once a second.
  absl::Time looks_from() const { return absl::FromUnixNanos(looks_from_ns_); }

 private:
  // A stream that waits for the one attached to end.
  struct Successor {
    AttachOptions options;
    EndStream end_stream;
    Done done;
  };

  absl::Status CheckNoneAwaitsReset(const Request& request) const;
  // Tells taps of a part that was carried out, or of the failure of one.
  void TellTaps(const Request& request, Part part, const Batch& batch, bool ok)
      ABSL_LOCKS_EXCLUDED(taps_mutex_);
  // States were put in, which nobody has drawn.
  void TellTapsOfStates() ABSL_LOCKS_EXCLUDED(taps_mutex_);
  // Counts and remembers what was done in a part that was carried out, or that failed.
  void Remember(const Request& request, const StepInput& input, const Batch& batch, bool ok);
  // `done`, where an error gives the number of `request` back.
  Done OrTakeBack(const Request& request, Done done);
  // The answer to a request that was carried out before.
  absl::StatusOr<Answer> Recall(const Request& request);
  // Lets go of what the stream has done with, answers and batches of shared memory, and fills in
  // the batch that is written.
  absl::Status Take(Request* request) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckHeldBatches(const AttachOptions& options) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status GrowSharedRing(int32_t batch_count);
  absl::Status CheckAttach(const AttachOptions& options) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status ReserveAnswers(int32_t count) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Gives back what is reserved beyond the answers that are kept and those that the present stream
  // and its successor may have kept.
  void TrimReservation() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void BeginStream(const AttachOptions& options, EndStream end_stream)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void BeginLease() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Reports the close to all that it concerns. `closed_` must be set.
  void TellClosed(const absl::Status& reason);
  // An answer of the pool, kept, has no more bytes.
  int64_t AnswerBytesMax() const;

  const std::string owner_;
  const std::string name_;
  const std::unique_ptr<HostedPool> pool_;
  const ObservationCoding coding_;
  const PoolSurroundings surroundings_;
  const absl::Time create_time_;
  PoolCounts counts_;                              // changed in a turn
  RequestTimes request_times_;                     // likewise
  std::atomic<int64_t> next_sequence_number_ = 1;  // written in a turn
  // Grown while a stream attaches, written in a turn of a stream. Null: it shares no memory.
  const std::unique_ptr<SharedRing> shared_ring_;

  mutable absl::Mutex mutex_;
  bool attached_ ABSL_GUARDED_BY(mutex_) = false;
  Owners::Share stream_share_ ABSL_GUARDED_BY(mutex_);    // while attached; who takes over has it
  AttachOptions stream_options_ ABSL_GUARDED_BY(mutex_);  // of the last one attached
  EndStream end_stream_ ABSL_GUARDED_BY(mutex_);          // null once called
  std::optional<Successor> successor_ ABSL_GUARDED_BY(mutex_);
  absl::Duration lease_duration_ ABSL_GUARDED_BY(mutex_);
  absl::Time expire_time_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
  KeptAnswers kept_ ABSL_GUARDED_BY(mutex_);
  int64_t reserved_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // for kept_
  BatchLedger batches_ ABSL_GUARDED_BY(mutex_);         // of shared_ring_
  bool turn_taken_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<Done> waiting_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  // OK while open

  std::atomic<int64_t> looks_from_ns_ = 0;  // of looks_from()

  absl::Mutex taps_mutex_;
  std::vector<std::shared_ptr<PoolTap>> taps_ ABSL_GUARDED_BY(taps_mutex_);
  absl::Status taps_end_ ABSL_GUARDED_BY(taps_mutex_);  // OK while they may be added
  std::atomic<bool> is_tapped_ = false;                 // taps_ has some

  std::atomic<int64_t> change_number_ = 0;  // written in a turn

  // Of who has the turn; memory is kept from turn to turn.
  std::vector<NextLevel> part_next_levels_;  // those of the part
  std::vector<Reset> part_resets_;           // those of the part
  BatchNumbers unasked_;  // what is read of a batch here and its learner has not asked for
  std::unique_ptr<EpisodeLog> episodes_;  // null: none are remembered
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_SESSION_H_
