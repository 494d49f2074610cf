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

// Replaces the content of `response` with an error.
void SetError(const absl::Status& status, dm::EnvironmentResponse* response);

// One stream of the protocol, independent of gRPC. Each request gets one response; an error
// response means that nothing changed.
//
// Threads: compatible, one call at a time; a call of Answer lasts until its `done`. CancelWait may
// be called from any thread at any time.
class DmEnvRpcSession {
 public:
  using Done = absl::AnyInvocable<void(const absl::Status&)>;

  // Worlds are pools of `owner`. `on_drain` is called, on any thread, when the server drains while
  // a world is joined. `supervisor` and `worlds` must outlive this.
  DmEnvRpcSession(PoolSupervisor* supervisor, JoinedWorlds* worlds, std::string owner,
                  JoinedWorld::OnDrain on_drain);
  // REQUIRES: End was called after the last Answer.
  ~DmEnvRpcSession() = default;
  DmEnvRpcSession(const DmEnvRpcSession&) = delete;
  DmEnvRpcSession& operator=(const DmEnvRpcSession&) = delete;

  // Fills `response`, which contains an error if the request failed. Calls `done` once, on any
  // thread, with that error or OK. `request` and `response` must stay valid until then. The session
  // is not accessed after `done`.
  void Answer(const dm::EnvironmentRequest& request, dm::EnvironmentResponse* response, Done done);

  // Ends waiting for other streams, now and in later calls: such a request gets CANCELLED.
  void CancelWait();

  // Leaves the joined world, if there is one.
  void End();

 private:
  void Dispatch(const dm::EnvironmentRequest& request);
  void Finish(const absl::Status& status);
  // If the joined world was lost, leaves it and returns the reason; otherwise OK.
  absl::Status DropLostWorld();
  absl::Status CheckJoined() const;
  // Returns the owner's world of this name. Errors: INVALID_ARGUMENT the name is too long; those of
  // PoolSupervisor::Find.
  absl::StatusOr<std::shared_ptr<PoolSession>> FindWorld(const std::string& name) const;

  void CreateWorld(const dm::CreateWorldRequest& request);
  void JoinWorld(const dm::JoinWorldRequest& request);
  void OnJoined(absl::StatusOr<std::shared_ptr<JoinedWorld>> world,
                const WorldSignature& signature);
  void Step(const dm::StepRequest& request);
  void Reset(const dm::ResetRequest& request);
  void ResetWorld(const dm::ResetWorldRequest& request);
  void Interrupt(JoinedWorld* other, std::shared_ptr<PoolSession> pool,
                 const EpisodeSettings& settings);
  void ResetUnjoined(std::shared_ptr<PoolSession> pool, const EpisodeSettings& settings);
  absl::Status DestroyWorld(const dm::DestroyWorldRequest& request);
  void AnswerExtension(const google::protobuf::Any& extension);

  PoolSupervisor* const supervisor_;
  JoinedWorlds* const worlds_;
  const std::string owner_;
  const JoinedWorld::OnDrain on_drain_;
  std::unique_ptr<WorldSession> world_session_;  // null: no world is joined

  // Of the current request.
  dm::EnvironmentResponse* response_ = nullptr;
  Done done_;
  dm_properties::PropertyRequest property_request_;
  dm_properties::PropertyResponse property_response_;

  absl::Mutex mutex_;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  // The interruption that the current request waits for; null: none.
  std::shared_ptr<Interruption> interruption_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_DM_ENV_RPC_SESSION_H_
