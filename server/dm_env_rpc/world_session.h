#ifndef SERVER_DM_ENV_RPC_WORLD_SESSION_H_
#define SERVER_DM_ENV_RPC_WORLD_SESSION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/dm_env_rpc/joined_world.h"
#include "server/dm_env_rpc/step_values.h"
#include "server/dm_env_rpc/world_specs.h"

namespace procgen {

// The state machine of a joined world: maps the protocol's steps and states to requests of a pool.
//
// While the state is RUNNING, a step executes its actions. Otherwise (after joining, an episode's
// end or a reset) a step ignores its actions and begins: environments that are not at the first
// observation of an episode are reset, the others return that observation. A restored state is
// returned unchanged.
//
// Threads: compatible, one call at a time. A call lasts until its `done`, which is called on any
// thread; the object is not accessed afterwards.
class WorldSession {
 public:
  using Done = PoolSession::Done;

  WorldSession(std::shared_ptr<JoinedWorld> world, const WorldSignature& signature);

  const WorldSignature& signature() const { return signature_; }
  JoinedWorld& world() const { return *world_; }
  // Seeds of the current levels [N].
  const std::vector<int32_t>& level_seeds() const { return values_.level_seeds(); }

  // Reads the current state of the pool. Must be called first, or ResetNow.
  void Observe(Done done);

  // Executes a step. On an error no environment has moved. `request` and `response` must stay valid
  // until `done`.
  // Errors: those of CheckRequestedObservations, ReadActions and JoinedWorld::Run.
  void Step(const dm::StepRequest& request, int64_t response_bytes_max, dm::StepResponse* response,
            Done done);

  // Makes the next step begin new episodes in all environments. No effect if `settings` is empty
  // and the state is not RUNNING. Errors: those of ReadEpisodeSettings.
  absl::Status Reset(const Settings& settings);

  // Resets all environments immediately.
  void ResetNow(const EpisodeSettings& settings, Done done);

  // Sets the level of the next episode of `environment`.
  void SetNextLevel(int32_t environment, int32_t level_seed);

  // Calls `done` with a snapshot of `environment`.
  using SaveDone = absl::AnyInvocable<void(absl::StatusOr<std::string>)>;
  void SaveState(int32_t environment, SaveDone done);

  // Restores `environment` from `snapshot`, which must stay valid until `done`.
  // Errors: those of Pool::RestoreStates.
  void RestoreState(int32_t environment, absl::string_view snapshot, Done done);

 private:
  // What the next request does to an environment.
  struct Next {
    std::optional<int32_t> level_seed;
    std::optional<int64_t> rand_seed;
    bool restored = false;  // its state was restored; no reset on begin
  };

  void TakeActions(const dm::StepRequest& request, dm::StepResponse* response, Done done);
  void AnswerInterrupted(const dm::StepRequest& request, dm::StepResponse* response, Done done);
  void Begin(const dm::StepRequest& request, dm::StepResponse* response, Done done);
  // Executes `pool_request` and fills `response`. `state`: the state to report; absent: derived
  // from the result.
  void Run(const Request& pool_request, std::optional<dm::EnvironmentStateType> state,
           const dm::StepRequest& request, dm::StepResponse* response, Done done);
  void OnRun(const absl::Status& status, std::optional<dm::EnvironmentStateType> state,
             const dm::StepRequest& request, dm::StepResponse* response);
  dm::EnvironmentStateType StateAfterActions() const;
  void ApplySettings(const EpisodeSettings& settings);
  void SettleInterruptions(Interruption::End end);

  const std::shared_ptr<JoinedWorld> world_;
  const WorldSignature signature_;
  StepValues values_;
  bool running_ = false;
  bool reset_all_ = false;  // the next step resets all environments
  std::vector<Next> next_;  // [N]

  // Of the current call. Members, so that their memory is reused.
  std::vector<int32_t> actions_;
  std::vector<NextLevel> next_levels_;
  std::vector<procgen::Reset> resets_;
  std::vector<std::shared_ptr<Interruption>> interruptions_;
  int32_t saved_environment_ = 0;
  std::string saved_;
};

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_WORLD_SESSION_H_
