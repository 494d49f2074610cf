#ifndef SERVER_DM_ENV_RPC_JOINED_WORLD_H_
#define SERVER_DM_ENV_RPC_JOINED_WORLD_H_

#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/dm_env_rpc/world_settings.h"
#include "server/session/pool/pool_session.h"

namespace procgen {

class JoinedWorlds;

// A reset of a world that another stream has joined. It is settled once: when that stream has been
// told, when it has left the world, or when nobody waits for it any more.
// Threads: any method from any thread.
class Interruption {
 public:
  enum class End { kTold, kLeft, kGivenUp };
  using Done = absl::AnyInvocable<void(End)>;

  // `settings`: of the episodes that follow. `done` is called when it is settled.
  Interruption(EpisodeSettings settings, Done done)
      : settings_(std::move(settings)), done_(std::move(done)) {}

  const EpisodeSettings& settings() const { return settings_; }
  // Whether it waits.
  bool IsOpen() const;
  // Settles it, unless it is.
  void Settle(End end);

 private:
  const EpisodeSettings settings_;
  mutable absl::Mutex mutex_;
  Done done_ ABSL_GUARDED_BY(mutex_);  // null: settled
};

// A pool as a stream has joined it: attached to it, and taking turns. It can be lost at any time:
// to a stream that takes over, to who deletes the pool, to a lease or a drain; what runs is carried
// out before the pool is let go. Threads: any method from any thread, but one use (InTurn, Run) at
// a time, and Leave not during one. Lock order: mutex_ is held by none of the calls out.
class JoinedWorld : public std::enable_shared_from_this<JoinedWorld> {
 public:
  using Done = PoolSession::Done;
  using JoinDone = absl::AnyInvocable<void(absl::StatusOr<std::shared_ptr<JoinedWorld>>)>;
  // Something done in a turn at the pool, which ends when `end` is called, once.
  using Work = absl::AnyInvocable<void(PoolSession* pool, Done end)>;
  using OnDrain = std::function<void(const absl::Status&)>;

  // Joins `pool` and calls `done` once. `on_drain` is called when the server drains. Until Leave,
  // others find it in `worlds`, which must outlive it. Errors: those of PoolSession::Attach;
  // FAILED_PRECONDITION the pool shares memory with its learners.
  static void Join(std::shared_ptr<PoolSession> pool, JoinedWorlds* worlds, OnDrain on_drain,
                   JoinDone done);

  // OK as long as it is joined; otherwise by what it was lost.
  absl::Status status() const;
  // Whether this is what is joined, or was.
  bool Is(const PoolSession& pool) const { return identity_ == &pool; }

  // Takes a turn for `work`, and calls `done` when it has ended, with the error if there is one.
  void InTurn(Work work, Done done);
  // Carries out a request on the whole pool in a turn of its own. What the spans in it and `batch`
  // refer to must stay valid until `done`. Errors: those of PoolSession::Execute.
  void Run(const Request& request, const Batch& batch, Done done);
  // Lets go of the pool.
  void Leave();

  // Has the stream that has joined told of a reset, with its next step.
  void Interrupt(std::shared_ptr<Interruption> interruption);
  // The interruptions that it was not told of yet; they must be settled.
  std::vector<std::shared_ptr<Interruption>> TakeInterruptions();

 private:
  JoinedWorld(std::shared_ptr<PoolSession> pool, JoinedWorlds* worlds, OnDrain on_drain);

  void OnStreamEnd(StreamEnd why, const absl::Status& reason);
  // The pool, for a use; null: it is lost.
  std::shared_ptr<PoolSession> BeginUse();
  void EndUse();
  void Detach(const std::shared_ptr<PoolSession>& pool);

  const PoolSession* const identity_;
  JoinedWorlds* const worlds_;
  const OnDrain on_drain_;
  Request request_;  // the one that runs

  mutable absl::Mutex mutex_;
  std::shared_ptr<PoolSession> pool_ ABSL_GUARDED_BY(mutex_);  // null: let go
  bool in_use_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status lost_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<Interruption>> interruptions_ ABSL_GUARDED_BY(mutex_);
};

// Who has joined what, of all streams of a server. Threads: any method from any thread.
class JoinedWorlds {
 public:
  // Who has joined `pool`; null: nobody.
  std::shared_ptr<JoinedWorld> Find(const PoolSession& pool) const;

 private:
  friend class JoinedWorld;
  void Add(const PoolSession* pool, std::weak_ptr<JoinedWorld> joined);
  void Remove(const PoolSession* pool, const JoinedWorld* joined);

  mutable absl::Mutex mutex_;
  std::map<const PoolSession*, std::weak_ptr<JoinedWorld>> joined_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_JOINED_WORLD_H_
