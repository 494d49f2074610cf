#include "server/dm_env_rpc/dm_env_rpc_session.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/dm_env_rpc/world_settings.h"
#include "server/dm_env_rpc/world_specs.h"

namespace procgen {
namespace {

// No world has a longer name, in bytes.
constexpr size_t kWorldNameBytesMax = 69;

// What is no name at all is not looked for: errors repeat names, but not whatever comes.
absl::Status CheckWorldName(const std::string& name) {
  if (name.size() > kWorldNameBytesMax) {
    return absl::InvalidArgumentError(absl::StrCat(
        "world_name is '", Shown(name), "', allowed: at most ", kWorldNameBytesMax, " characters"));
  }
  return absl::OkStatus();
}

}  // namespace

void SetError(const absl::Status& status, dm::EnvironmentResponse* response) {
  response->Clear();
  response->mutable_error()->set_code(static_cast<int32_t>(status.code()));
  response->mutable_error()->set_message(std::string(status.message()));
}

DmEnvRpcSession::DmEnvRpcSession(PoolSupervisor* supervisor, JoinedWorlds* worlds,
                                 std::string owner, JoinedWorld::OnDrain on_drain)
    : supervisor_(supervisor),
      worlds_(worlds),
      owner_(std::move(owner)),
      on_drain_(std::move(on_drain)) {}

void DmEnvRpcSession::Answer(const dm::EnvironmentRequest& request,
                             dm::EnvironmentResponse* response, Done done) {
  response->Clear();
  response_ = response;
  done_ = std::move(done);
  Dispatch(request);
}

void DmEnvRpcSession::Dispatch(const dm::EnvironmentRequest& request) {
  const absl::Status lost = DropLostWorld();
  switch (request.payload_case()) {
    case dm::EnvironmentRequest::kCreateWorld:
      CreateWorld(request.create_world());
      return;
    case dm::EnvironmentRequest::kJoinWorld:
      JoinWorld(request.join_world());
      return;
    case dm::EnvironmentRequest::kStep:
      lost.ok() ? Step(request.step()) : Finish(lost);
      return;
    case dm::EnvironmentRequest::kReset:
      lost.ok() ? Reset(request.reset()) : Finish(lost);
      return;
    case dm::EnvironmentRequest::kResetWorld:
      ResetWorld(request.reset_world());
      return;
    case dm::EnvironmentRequest::kLeaveWorld:
      End();
      response_->mutable_leave_world();
      Finish(absl::OkStatus());
      return;
    case dm::EnvironmentRequest::kDestroyWorld:
      response_->mutable_destroy_world();
      Finish(DestroyWorld(request.destroy_world()));
      return;
    case dm::EnvironmentRequest::kExtension:
      lost.ok() ? Extend(request.extension()) : Finish(lost);
      return;
    case dm::EnvironmentRequest::PAYLOAD_NOT_SET:
      break;
  }
  Finish(absl::InvalidArgumentError(
      "the request asks for nothing, allowed: create_world, join_world, step, reset, reset_world, "
      "leave_world, destroy_world, extension"));
}

void DmEnvRpcSession::Finish(const absl::Status& status) {
  if (!status.ok()) {
    SetError(status, response_);
  }
  // Out of here first: the next request may come before the call returns.
  Done done = std::move(done_);
  done(status);
}

void DmEnvRpcSession::GiveUp() {
  std::shared_ptr<Interruption> interruption;
  {
    absl::MutexLock lock(&mutex_);
    given_up_ = true;
    interruption = interruption_;
  }
  if (interruption != nullptr) {
    interruption->Settle(Interruption::End::kGivenUp);
  }
}

void DmEnvRpcSession::End() {
  if (play_ != nullptr) {
    play_->world().Leave();
    play_ = nullptr;
  }
}

absl::Status DmEnvRpcSession::DropLostWorld() {
  if (play_ == nullptr) {
    return absl::OkStatus();
  }
  absl::Status status = play_->world().status();
  if (!status.ok()) {
    End();
  }
  return status;
}

absl::Status DmEnvRpcSession::CheckJoined() const {
  if (play_ == nullptr) {
    return absl::FailedPreconditionError("no world is joined; join one first");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<PoolSession>> DmEnvRpcSession::FindWorld(
    const std::string& name) const {
  if (absl::Status status = CheckWorldName(name); !status.ok()) {
    return status;
  }
  return supervisor_->Find(owner_, name);
}

void DmEnvRpcSession::CreateWorld(const dm::CreateWorldRequest& request) {
  const absl::StatusOr<WorldPlan> plan =
      ReadWorldSettings(request.settings(), supervisor_->limits());
  if (!plan.ok()) {
    Finish(plan.status());
    return;
  }
  supervisor_->Create(owner_, plan->pool_id, plan->options, plan->session_options,
                      [this](const absl::StatusOr<std::shared_ptr<PoolSession>>& pool) {
                        if (pool.ok()) {
                          response_->mutable_create_world()->set_world_name((*pool)->name());
                        }
                        Finish(pool.status());
                      });
}

void DmEnvRpcSession::JoinWorld(const dm::JoinWorldRequest& request) {
  absl::Status status = CheckNoSettings("join_world", request.settings());
  status.Update(CheckWorldName(request.world_name()));
  if (play_ != nullptr) {
    status = absl::FailedPreconditionError("a world is joined; leave it before another is joined");
  }
  if (!status.ok()) {
    Finish(status);
    return;
  }
  absl::StatusOr<std::shared_ptr<PoolSession>> pool =
      supervisor_->FindForStream(owner_, request.world_name());
  if (!pool.ok()) {
    Finish(pool.status());
    return;
  }
  const WorldForm form = WorldForm::Of(**pool);
  JoinedWorld::Join(*std::move(pool), worlds_, on_drain_,
                    [this, form](absl::StatusOr<std::shared_ptr<JoinedWorld>> world) {
                      OnJoined(std::move(world), form);
                    });
}

void DmEnvRpcSession::OnJoined(absl::StatusOr<std::shared_ptr<JoinedWorld>> world,
                               const WorldForm& form) {
  if (!world.ok()) {
    Finish(world.status());
    return;
  }
  play_ = std::make_unique<WorldSession>(*std::move(world), form);
  play_->Observe([this](const absl::Status& status) {
    if (status.ok()) {
      supervisor_->metrics().AddStream(false);
      *response_->mutable_join_world()->mutable_specs() = SpecsOf(play_->form());
    } else {
      End();
    }
    Finish(status);
  });
}

void DmEnvRpcSession::Step(const dm::StepRequest& request) {
  if (absl::Status status = CheckJoined(); !status.ok()) {
    Finish(status);
    return;
  }
  play_->Step(request, supervisor_->limits().response_bytes_max, response_->mutable_step(),
              [this](const absl::Status& status) { Finish(status); });
}

void DmEnvRpcSession::Reset(const dm::ResetRequest& request) {
  absl::Status status = CheckJoined();
  if (status.ok()) {
    status = play_->Reset(request.settings());
  }
  if (status.ok()) {
    *response_->mutable_reset()->mutable_specs() = SpecsOf(play_->form());
  }
  Finish(status);
}

void DmEnvRpcSession::ResetWorld(const dm::ResetWorldRequest& request) {
  absl::StatusOr<std::shared_ptr<PoolSession>> pool = FindWorld(request.world_name());
  if (!pool.ok()) {
    Finish(pool.status());
    return;
  }
  response_->mutable_reset_world();
  if (play_ != nullptr && play_->world().Is(**pool)) {
    Finish(play_->Reset(request.settings()));
    return;
  }
  const absl::StatusOr<EpisodeSettings> settings =
      ReadEpisodeSettings(request.settings(), WorldForm::Of(**pool).shape());
  if (!settings.ok()) {
    Finish(settings.status());
    return;
  }
  if (const std::shared_ptr<JoinedWorld> other = worlds_->Find(**pool); other != nullptr) {
    Interrupt(other.get(), *std::move(pool), *settings);
  } else {
    ResetUnjoined(*std::move(pool), *settings);
  }
}

void DmEnvRpcSession::Interrupt(JoinedWorld* other, std::shared_ptr<PoolSession> pool,
                                const EpisodeSettings& settings) {
  auto interruption = std::make_shared<Interruption>(
      settings, [this, pool = std::move(pool), settings](Interruption::End end) {
        {
          absl::MutexLock lock(&mutex_);
          interruption_ = nullptr;
        }
        switch (end) {
          case Interruption::End::kTold:
            Finish(absl::OkStatus());
            return;
          case Interruption::End::kLeft:
            ResetUnjoined(pool, settings);
            return;
          case Interruption::End::kGivenUp:
            Finish(absl::CancelledError("the stream ended before the world's other agent stepped"));
            return;
        }
      });
  bool given_up = false;
  {
    absl::MutexLock lock(&mutex_);
    interruption_ = interruption;
    given_up = given_up_;
  }
  if (given_up) {
    interruption->Settle(Interruption::End::kGivenUp);
  } else {
    other->Interrupt(std::move(interruption));
  }
}

void DmEnvRpcSession::ResetUnjoined(std::shared_ptr<PoolSession> pool,
                                    const EpisodeSettings& settings) {
  const WorldForm form = WorldForm::Of(*pool);
  JoinedWorld::Join(std::move(pool), worlds_, on_drain_,
                    [this, form, settings](absl::StatusOr<std::shared_ptr<JoinedWorld>> world) {
                      if (!world.ok()) {
                        Finish(world.status());
                        return;
                      }
                      auto visit = std::make_shared<WorldSession>(*std::move(world), form);
                      visit->ResetNow(settings, [this, visit](const absl::Status& status) {
                        visit->world().Leave();
                        Finish(status);
                      });
                    });
}

absl::Status DmEnvRpcSession::DestroyWorld(const dm::DestroyWorldRequest& request) {
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool = FindWorld(request.world_name());
  if (!pool.ok()) {
    return pool.status();
  }
  if ((*pool)->attached()) {
    return absl::FailedPreconditionError(
        absl::StrCat("world ", (*pool)->name(),
                     play_ != nullptr && play_->world().Is(**pool) ? " is joined by this stream"
                                                                   : " is joined by another stream",
                     ", allowed: one that nobody has joined; leave it first"));
  }
  return supervisor_->Delete(owner_, request.world_name());
}

void DmEnvRpcSession::Extend(const google::protobuf::Any& extension) {
  property_request_.Clear();
  property_response_.Clear();
  if (!extension.Is<dm_properties::PropertyRequest>()) {
    Finish(absl::UnimplementedError(
        absl::StrCat("the extension has type ", Shown(extension.type_url()),
                     ", offered: ", dm_properties::PropertyRequest::descriptor()->full_name())));
    return;
  }
  if (!extension.UnpackTo(&property_request_)) {
    Finish(absl::InvalidArgumentError(
        absl::StrCat("the extension's ", extension.value().size(), " bytes are no valid ",
                     dm_properties::PropertyRequest::descriptor()->full_name())));
    return;
  }
  AnswerPropertyRequest(*supervisor_, owner_, play_.get(), property_request_, &property_response_,
                        [this](const absl::Status& status) {
                          if (status.ok()) {
                            response_->mutable_extension()->PackFrom(property_response_);
                          }
                          Finish(status);
                        });
}

}  // namespace procgen
