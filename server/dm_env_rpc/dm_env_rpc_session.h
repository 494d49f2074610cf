#ifndef SERVER_DM_ENV_RPC_DM_ENV_RPC_SESSION_H_
#define SERVER_DM_ENV_RPC_DM_ENV_RPC_SESSION_H_

#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/dm_env_rpc/joined_world.h"
#include "server/dm_env_rpc/properties.h"
#include "server/dm_env_rpc/world_session.h"
#include "server/session/pool_supervisor.h"

namespace procgen {

// Makes `response` an error.
void SetError(const absl::Status& status, dm::EnvironmentResponse* response);

// One stream of the protocol, free of the wire: each request is answered once, by what it asked for
// or by an error, which has changed nothing.
//
// Threads: compatible, one call at a time, Answer lasting until its `done`; but GiveUp from any
// thread at any time.
class DmEnvRpcSession {
 public:
  using Done = absl::AnyInvocable<void(const absl::Status&)>;

  // Of `owner`, whose pools its worlds are. `on_drain` is called, on any thread, when the server
  // drains while a world is joined. `supervisor` and `worlds` must outlive this.
  DmEnvRpcSession(PoolSupervisor* supervisor, JoinedWorlds* worlds, std::string owner,
                  JoinedWorld::OnDrain on_drain);
  // REQUIRES: End was called, if anything was answered.
  ~DmEnvRpcSession() = default;
  DmEnvRpcSession(const DmEnvRpcSession&) = delete;
  DmEnvRpcSession& operator=(const DmEnvRpcSession&) = delete;

  // Fills `response`, with an error if there is one, and calls `done` once, on any thread, with
  // that error or OK. Both must stay valid until then; nothing here is touched afterwards.
  void Answer(const dm::EnvironmentRequest& request, dm::EnvironmentResponse* response, Done done);

  // Waits for no other stream, now or later: what would is answered with CANCELLED.
  void GiveUp();

  // Leaves the world that is joined, if one is.
  void End();

 private:
  void Dispatch(const dm::EnvironmentRequest& request);
  void Finish(const absl::Status& status);
  // Ends the play of a world that was lost, and tells by what; OK: there is none.
  absl::Status DropLostWorld();
  absl::Status CheckJoined() const;
  // A world of the owner by its name. Errors: those of PoolSupervisor::Find.
  absl::StatusOr<std::shared_ptr<PoolSession>> FindWorld(const std::string& name) const;

  void CreateWorld(const dm::CreateWorldRequest& request);
  void JoinWorld(const dm::JoinWorldRequest& request);
  void OnJoined(absl::StatusOr<std::shared_ptr<JoinedWorld>> world, const WorldForm& form);
  void Step(const dm::StepRequest& request);
  void Reset(const dm::ResetRequest& request);
  void ResetWorld(const dm::ResetWorldRequest& request);
  void Interrupt(JoinedWorld* other, std::shared_ptr<PoolSession> pool,
                 const EpisodeSettings& settings);
  void ResetUnjoined(std::shared_ptr<PoolSession> pool, const EpisodeSettings& settings);
  absl::Status DestroyWorld(const dm::DestroyWorldRequest& request);
  void Extend(const google::protobuf::Any& extension);

  PoolSupervisor* const supervisor_;
  JoinedWorlds* const worlds_;
  const std::string owner_;
  const JoinedWorld::OnDrain on_drain_;
  std::unique_ptr<WorldSession> play_;  // null: no world is joined

  // Of the request that is answered.
  dm::EnvironmentResponse* response_ = nullptr;
  Done done_;
  dm_properties::PropertyRequest property_request_;
  dm_properties::PropertyResponse property_response_;

  absl::Mutex mutex_;
  bool given_up_ ABSL_GUARDED_BY(mutex_) = false;
  // What is waited for; null: nothing.
  std::shared_ptr<Interruption> interruption_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_DM_ENV_RPC_SESSION_H_
