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

// How a stream plays the world that it has joined: the protocol's states over a pool's steps.
//
// While it is running, a step takes its actions. Otherwise (after joining, at an episode's end,
// after a reset) a step ignores them and begins: environments that do not stand at the first
// observation of an episode get a new one, the others show it. A state that was written is shown as
// it is.
//
// Threads: compatible, one call at a time; a call has ended when its `done` is called, on any
// thread, and nothing of this is touched after that.
class WorldSession {
 public:
  using Done = PoolSession::Done;

  WorldSession(std::shared_ptr<JoinedWorld> world, const WorldForm& form);

  const WorldForm& form() const { return form_; }
  JoinedWorld& world() const { return *world_; }
  // The levels that are played [N].
  const std::vector<int32_t>& level_seeds() const { return values_.level_seeds(); }

  // Observes how the world stands; to be called first.
  void Observe(Done done);

  // Answers a step. What is wrong with it is found before anything moves. Errors: those of
  // CheckRequestedObservations, ReadActions and JoinedWorld::Run. `request` and `response` must
  // stay valid until `done`.
  void Step(const dm::StepRequest& request, int64_t response_bytes_max, dm::StepResponse* response,
            Done done);

  // The next step begins new episodes in all environments. Without settings, and where the next
  // step begins in any case, it changes nothing. Errors: those of ReadEpisodeSettings.
  absl::Status Reset(const Settings& settings);

  // Begins new episodes at once.
  void ResetNow(const EpisodeSettings& settings, Done done);

  // The level that `environment` plays next.
  void SetNextLevel(int32_t environment, int32_t level_seed);

  // A snapshot of `environment`.
  using SaveDone = absl::AnyInvocable<void(absl::StatusOr<std::string>)>;
  void SaveState(int32_t environment, SaveDone done);

  // Puts `environment` into a snapshot, which must stay valid until `done`. Errors: those of
  // Pool::RestoreStates.
  void RestoreState(int32_t environment, absl::string_view snapshot, Done done);

 private:
  // What is asked of an environment before it goes on.
  struct Next {
    std::optional<int32_t> level_seed;
    std::optional<int64_t> rand_seed;
    bool restored = false;  // it shows a state that was written
  };

  void TakeActions(const dm::StepRequest& request, dm::StepResponse* response, Done done);
  void TellInterruption(const dm::StepRequest& request, dm::StepResponse* response, Done done);
  void Begin(const dm::StepRequest& request, dm::StepResponse* response, Done done);
  // Carries out `asked` and tells what came of it; `state`: what to tell, absent: as it comes.
  void Run(const Request& asked, std::optional<dm::EnvironmentStateType> state,
           const dm::StepRequest& request, dm::StepResponse* response, Done done);
  void OnRun(const absl::Status& status, std::optional<dm::EnvironmentStateType> state,
             const dm::StepRequest& request, dm::StepResponse* response);
  dm::EnvironmentStateType StateAfterActions() const;
  void Adopt(const EpisodeSettings& settings);
  // Those who wait for this stream to be told of a reset.
  void SettleInterruptions(Interruption::End end);

  const std::shared_ptr<JoinedWorld> world_;
  const WorldForm form_;
  StepValues values_;
  bool running_ = false;
  bool reset_all_ = false;  // by the next step
  std::vector<Next> next_;  // [N]

  // Of the call under way; memory is kept from call to call.
  std::vector<int32_t> actions_;
  std::vector<NextLevel> next_levels_;
  std::vector<procgen::Reset> resets_;
  std::vector<std::shared_ptr<Interruption>> interruptions_;
  int32_t saved_environment_ = 0;
  std::string saved_;
};

}  // namespace procgen

#endif  // SERVER_DM_ENV_RPC_WORLD_SESSION_H_
