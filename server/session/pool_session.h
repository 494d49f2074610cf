#ifndef SERVER_SESSION_POOL_SESSION_H_
#define SERVER_SESSION_POOL_SESSION_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/session/owners.h"
#include "server/session/request.h"
#include "server/session/side_crew.h"

namespace procgen {

// How many may wait for their turn at one pool.
inline constexpr size_t kTurnsWaitingMax = 64;

// A pool on the server: its name, who has its stream, and whose turn it is.
//
// Whoever wants something of the pool takes turns: one at a time, in the order of asking. A turn is
// one whole request of a stream, or one call from beside it, so a call sees the pool between two
// requests. Nothing here blocks: a turn begins in a callback, and so do results arrive.
//
// Threads: any method from any thread, but those under "In a turn" only by who has the turn.
class PoolSession {
 public:
  // Calls that tell a stream why it must end; called once at most, and not after Detach.
  using EndStream = absl::AnyInvocable<void(absl::Status)>;
  using Done = absl::AnyInvocable<void(absl::Status)>;
  // Calls that are handed a snapshot of an environment; false: no more are wanted.
  using TakeState = absl::AnyInvocable<bool(int32_t environment, std::string snapshot)>;

  // `owners`, `side_crew` and `step_count` must outlive this; environment steps are added to
  // `step_count`.
  PoolSession(std::string owner, std::string name, std::unique_ptr<Pool> pool,
              absl::Time create_time, Owners* owners, SideCrew* side_crew,
              std::atomic<int64_t>* step_count);
  // REQUIRES: nobody has a turn.
  ~PoolSession();
  PoolSession(const PoolSession&) = delete;
  PoolSession& operator=(const PoolSession&) = delete;

  // Who made it; empty where callers are not asked who they are.
  const std::string& owner() const { return owner_; }
  const std::string& name() const { return name_; }
  const PoolOptions& options() const { return pool_->options(); }
  int32_t env_count() const { return pool_->env_count(); }
  // Bytes of one environment's observation.
  int64_t observation_bytes() const { return static_cast<int64_t>(pool_->observation_bytes()); }
  absl::Time create_time() const { return create_time_; }
  bool attached() const;
  // The number that the next new request must bear.
  int64_t next_sequence_number() const { return next_sequence_number_; }

  // Takes the pool for a stream. Errors: FAILED_PRECONDITION another stream has it; NOT_FOUND it
  // was closed; RESOURCE_EXHAUSTED its owner has too many streams.
  absl::Status Attach(EndStream end_stream);
  // Gives it back. A turn must have ended.
  void Detach();
  // Ends the stream, if one is attached, with `reason`; it detaches when its turn has ended.
  void End(const absl::Status& reason);
  // Ends the stream, and lets none attach and no turn begin any more: those that ask are told.
  void Close(const absl::Status& reason);

  // Calls `begin` with OK when it is the caller's turn (on this thread, or one that ends a turn),
  // who then must call EndTurn once; or with an error, and it has no turn: after Close, its reason;
  // RESOURCE_EXHAUSTED kTurnsWaitingMax others wait.
  void TakeTurn(Done begin);
  void EndTurn();

  // In a turn:

  // Checks a request of the stream, fills in its count, and takes it: its number counts as used.
  // Errors, which take nothing: INVALID_ARGUMENT; UNIMPLEMENTED a number that was used before;
  // FAILED_PRECONDITION an environment that must be reset.
  absl::Status Accept(Request* request);
  // Carries out a part of an accepted request. Returns at once; `done` is called once, on a
  // worker's thread or, with an error, on this one. `request` and the memory of `batch` must stay
  // valid until then.
  void RunPart(const Request& request, Part part, const Batch& batch, Done done);
  // A number that is another one whenever environments were stepped, reset or restored.
  int64_t change_number() const { return change_number_; }
  // Takes snapshots of `environments`, in their order, on another thread, and hands each to `take`
  // there until no more are wanted. The span must stay valid until then. Errors: those of
  // Pool::SaveStates.
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done);
  // As those of Pool, on another thread. What the spans in `states` refer to must stay valid.
  void RestoreStates(std::vector<StateToRestore> states, Done done);
  void CloneStates(std::vector<StateToClone> pairs, Done done);
  // Draws the human view of environments, as Pool::Render, on another thread. `frames`: one for
  // each of `environments`.
  void Render(absl::Span<const int32_t> environments, int32_t side_px,
              std::vector<absl::Span<uint8_t>> frames, Done done);

 private:
  absl::Status CheckNoneAwaitsReset(const Request& request) const;

  const std::string owner_;
  const std::string name_;
  const std::unique_ptr<Pool> pool_;
  const absl::Time create_time_;
  Owners* const owners_;
  SideCrew* const side_crew_;
  std::atomic<int64_t>* const step_count_;
  std::atomic<int64_t> next_sequence_number_ = 1;  // written in a turn

  mutable absl::Mutex mutex_;
  bool attached_ ABSL_GUARDED_BY(mutex_) = false;
  Owners::Share stream_share_ ABSL_GUARDED_BY(mutex_);  // while attached
  EndStream end_stream_ ABSL_GUARDED_BY(mutex_);        // null once called
  bool turn_taken_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<Done> waiting_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  // OK while open

  // Of who has the turn; memory is kept from turn to turn.
  int64_t change_number_ = 0;
  std::vector<NextLevel> part_next_levels_;  // those of the part
  std::vector<Reset> part_resets_;           // those of the part
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_SESSION_H_
