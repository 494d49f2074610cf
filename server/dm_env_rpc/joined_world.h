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

// A request to reset a world that another stream has joined. It is settled once: when that stream
// was notified, when that stream left the world, or when the request was cancelled.
// Threads: any method from any thread.
class Interruption {
 public:
  enum class End { kNotified, kLeft, kCancelled };
  using Done = absl::AnyInvocable<void(End)>;

  // `settings`: of the next episodes. `done` is called when the interruption is settled.
  Interruption(EpisodeSettings settings, Done done)
      : settings_(std::move(settings)), done_(std::move(done)) {}

  const EpisodeSettings& settings() const { return settings_; }
  // Whether it is not settled yet.
  bool IsOpen() const;
  // Settles it and calls `done`. No effect if it is settled already.
  void Settle(End end);

 private:
  const EpisodeSettings settings_;
  mutable absl::Mutex mutex_;
  Done done_ ABSL_GUARDED_BY(mutex_);  // null: settled
};

// A pool that a stream has joined: the stream is attached to it and takes turns. It can be lost at
// any time: by a take-over, a deletion or a drain. A running request completes before the pool is
// detached.
// Threads: any method from any thread, but one use (InTurn, Run) at a time, and no Leave during
// one.
// Lock order: mutex_ is not held during calls to other objects.
class JoinedWorld : public std::enable_shared_from_this<JoinedWorld> {
 public:
  using Done = PoolSession::Done;
  using JoinDone = absl::AnyInvocable<void(absl::StatusOr<std::shared_ptr<JoinedWorld>>)>;
  // Work in a turn of the pool. It calls `end` once, which ends the turn.
  using Work = absl::AnyInvocable<void(PoolSession* pool, Done end)>;
  using OnDrain = std::function<void(const absl::Status&)>;

  // Joins `pool` and calls `done` once. `on_drain` is called when the server drains. Until Leave,
  // other streams find it in `worlds`, which must outlive it.
  // Errors: those of PoolSession::Attach; FAILED_PRECONDITION the pool shares memory with its
  // learners.
  static void Join(std::shared_ptr<PoolSession> pool, JoinedWorlds* worlds, OnDrain on_drain,
                   JoinDone done);

  // OK until the pool is lost; then the reason.
  absl::Status status() const;
  // Whether `pool` is the joined pool, also after it was lost or left.
  bool Is(const PoolSession& pool) const { return identity_ == &pool; }

  // Runs `work` in a turn, then calls `done` with its status or the error that prevented it.
  void InTurn(Work work, Done done);
  // Executes a request on the whole pool in its own turn. The memory that the spans of `request`
  // and `batch` refer to must stay valid until `done`. Errors: those of PoolSession::Execute.
  void Run(const Request& request, const Batch& batch, Done done);
  // Detaches from the pool.
  void Leave();

  // Queues a reset. The next step of the stream that joined this world reports it.
  void Interrupt(std::shared_ptr<Interruption> interruption);
  // Removes and returns the open interruptions; the caller must settle them.
  std::vector<std::shared_ptr<Interruption>> TakeInterruptions();

 private:
  JoinedWorld(std::shared_ptr<PoolSession> pool, JoinedWorlds* worlds, OnDrain on_drain);

  void OnStreamEnd(StreamEnd why, const absl::Status& reason);
  // Begins a use and returns the pool; null: it is lost or left.
  std::shared_ptr<PoolSession> BeginUse();
  void EndUse();
  void Detach(const std::shared_ptr<PoolSession>& pool);

  const PoolSession* const identity_;
  JoinedWorlds* const worlds_;
  const OnDrain on_drain_;
  Request request_;  // the running one

  mutable absl::Mutex mutex_;
  std::shared_ptr<PoolSession> pool_ ABSL_GUARDED_BY(mutex_);  // null: detached
  bool in_use_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status lost_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<Interruption>> interruptions_ ABSL_GUARDED_BY(mutex_);
};

// The joined worlds of all streams of a server.
// Threads: any method from any thread.
class JoinedWorlds {
 public:
  // Returns the joined world of `pool`; null: no stream has joined it.
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
