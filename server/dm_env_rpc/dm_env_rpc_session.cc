#include "server/dm_env_rpc/dm_env_rpc_session.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/dm_env_rpc/world_settings.h"
#include "server/dm_env_rpc/world_specs.h"

namespace procgen {
namespace {

// Largest size of a world's name, in bytes.
constexpr size_t kWorldNameBytesMax = 69;

// Bounds the length of names, because errors repeat them.
absl::Status CheckWorldName(const std::string& name) {
  if (name.size() > kWorldNameBytesMax) {
    return absl::InvalidArgumentError(absl::StrCat("world_name is '", Truncated(name),
                                                   "', allowed: at most ", kWorldNameBytesMax,
                                                   " characters"));
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
      lost.ok() ? AnswerExtension(request.extension()) : Finish(lost);
      return;
    case dm::EnvironmentRequest::PAYLOAD_NOT_SET:
      break;
  }
  Finish(absl::InvalidArgumentError(
      "the request is empty, allowed: create_world, join_world, step, reset, reset_world, "
      "leave_world, destroy_world, extension"));
}

void DmEnvRpcSession::Finish(const absl::Status& status) {
  if (!status.ok()) {
    SetError(status, response_);
  }
  // Moved out first: the next request may arrive before done() returns.
  Done done = std::move(done_);
  done(status);
}

void DmEnvRpcSession::CancelWait() {
  std::shared_ptr<Interruption> interruption;
  {
    absl::MutexLock lock(&mutex_);
    cancelled_ = true;
    interruption = interruption_;
  }
  if (interruption != nullptr) {
    interruption->Settle(Interruption::End::kCancelled);
  }
}

void DmEnvRpcSession::End() {
  if (world_session_ != nullptr) {
    world_session_->world().Leave();
    world_session_ = nullptr;
  }
}

absl::Status DmEnvRpcSession::DropLostWorld() {
  if (world_session_ == nullptr) {
    return absl::OkStatus();
  }
  absl::Status status = world_session_->world().status();
  if (!status.ok()) {
    End();
  }
  return status;
}

absl::Status DmEnvRpcSession::CheckJoined() const {
  if (world_session_ == nullptr) {
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
  const absl::StatusOr<WorldOptions> options =
      ReadWorldSettings(request.settings(), supervisor_->limits());
  if (!options.ok()) {
    Finish(options.status());
    return;
  }
  supervisor_->Create(owner_, options->pool_id, options->pool_options, options->session_options,
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
  if (world_session_ != nullptr) {
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
  const WorldSignature signature = WorldSignature::Of(**pool);
  JoinedWorld::Join(*std::move(pool), worlds_, on_drain_,
                    [this, signature](absl::StatusOr<std::shared_ptr<JoinedWorld>> world) {
                      OnJoined(std::move(world), signature);
                    });
}

void DmEnvRpcSession::OnJoined(absl::StatusOr<std::shared_ptr<JoinedWorld>> world,
                               const WorldSignature& signature) {
  if (!world.ok()) {
    Finish(world.status());
    return;
  }
  world_session_ = std::make_unique<WorldSession>(*std::move(world), signature);
  world_session_->Observe([this](const absl::Status& status) {
    if (status.ok()) {
      supervisor_->metrics().AddStream(false);
      *response_->mutable_join_world()->mutable_specs() = SpecsOf(world_session_->signature());
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
  world_session_->Step(request, supervisor_->limits().response_bytes_max, response_->mutable_step(),
                       [this](const absl::Status& status) { Finish(status); });
}

void DmEnvRpcSession::Reset(const dm::ResetRequest& request) {
  absl::Status status = CheckJoined();
  if (status.ok()) {
    status = world_session_->Reset(request.settings());
  }
  if (status.ok()) {
    *response_->mutable_reset()->mutable_specs() = SpecsOf(world_session_->signature());
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
  if (world_session_ != nullptr && world_session_->world().Is(**pool)) {
    Finish(world_session_->Reset(request.settings()));
    return;
  }
  const absl::StatusOr<EpisodeSettings> settings =
      ReadEpisodeSettings(request.settings(), WorldSignature::Of(**pool).shape());
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
          case Interruption::End::kNotified:
            Finish(absl::OkStatus());
            return;
          case Interruption::End::kLeft:
            ResetUnjoined(pool, settings);
            return;
          case Interruption::End::kCancelled:
            Finish(absl::CancelledError("the stream ended before the world's other agent stepped"));
            return;
        }
      });
  bool cancelled = false;
  {
    absl::MutexLock lock(&mutex_);
    interruption_ = interruption;
    cancelled = cancelled_;
  }
  if (cancelled) {
    interruption->Settle(Interruption::End::kCancelled);
  } else {
    other->Interrupt(std::move(interruption));
  }
}

void DmEnvRpcSession::ResetUnjoined(std::shared_ptr<PoolSession> pool,
                                    const EpisodeSettings& settings) {
  const WorldSignature signature = WorldSignature::Of(*pool);
  JoinedWorld::Join(
      std::move(pool), worlds_, on_drain_,
      [this, signature, settings](absl::StatusOr<std::shared_ptr<JoinedWorld>> world) {
        if (!world.ok()) {
          Finish(world.status());
          return;
        }
        auto session = std::make_shared<WorldSession>(*std::move(world), signature);
        session->ResetNow(settings, [this, session](const absl::Status& status) {
          session->world().Leave();
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
                     world_session_ != nullptr && world_session_->world().Is(**pool)
                         ? " is joined by this stream"
                         : " is joined by another stream",
                     ", allowed: a world that no stream has joined; leave it first"));
  }
  return supervisor_->Delete(owner_, request.world_name());
}

void DmEnvRpcSession::AnswerExtension(const google::protobuf::Any& extension) {
  property_request_.Clear();
  property_response_.Clear();
  if (!extension.Is<dm_properties::PropertyRequest>()) {
    Finish(absl::UnimplementedError(
        absl::StrCat("the extension has type ", Truncated(extension.type_url()),
                     ", offered: ", dm_properties::PropertyRequest::descriptor()->full_name())));
    return;
  }
  if (!extension.UnpackTo(&property_request_)) {
    Finish(absl::InvalidArgumentError(
        absl::StrCat("the extension's ", extension.value().size(), " bytes are not a valid ",
                     dm_properties::PropertyRequest::descriptor()->full_name())));
    return;
  }
  AnswerPropertyRequest(*supervisor_, owner_, world_session_.get(), property_request_,
                        &property_response_, [this](const absl::Status& status) {
                          if (status.ok()) {
                            response_->mutable_extension()->PackFrom(property_response_);
                          }
                          Finish(status);
                        });
}

}  // namespace procgen
