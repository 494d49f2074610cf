#include "server/rpc/run/pool_run.h"

#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/pool/environment_list.h"
#include "server/wire/convert_frames.h"
#include "server/wire/convert_observation.h"
#include "server/wire/convert_pool.h"
#include "server/wire/convert_step.h"

namespace procgen {

PoolRun::PoolRun(PoolSupervisor* supervisor, std::string owner, OnEnd on_end)
    : supervisor_(supervisor), owner_(std::move(owner)), on_end_(std::move(on_end)) {}

void PoolRun::Execute(const v1::RunPoolRequest& message, absl::Time arrival_time, Respond respond) {
  respond_ = std::move(respond);
  if (message.has_start() != (pool_ == nullptr)) {
    RespondWith(absl::InvalidArgumentError(
        pool_ == nullptr ? "the first request of a stream has no start"
                         : "start was sent again, allowed: once, as the first request"));
    return;
  }
  switch (message.request_case()) {
    case v1::RunPoolRequest::kStart:
      Start(message.start());
      break;
    case v1::RunPoolRequest::kSaveStates:
      Save(message.save_states());
      break;
    case v1::RunPoolRequest::kRestoreStates:
      Restore(message.restore_states().states(),
              [this](const absl::Status& status) { RespondAck(status); });
      break;
    case v1::RunPoolRequest::kCloneStates:
      Clone(message.clone_states());
      break;
    case v1::RunPoolRequest::kRender:
      Render(message.render());
      break;
    default:
      ExecuteBatch(message, arrival_time);
  }
}

void PoolRun::OnLearnerGone() {
  if (pool_ != nullptr) {
    pool_->OnStreamEnds();
  }
}

void PoolRun::Close() {
  if (pool_ != nullptr) {
    supervisor_->Free(pool_.get());
  }
}

void PoolRun::Start(const v1::StartPool& start) {
  absl::StatusOr<PoolOptions> options = PoolOptionsOf(start.spec());
  const absl::StatusOr<SessionOptions> session_options = SessionOptionsOf(start.spec());
  absl::Status status = options.status();
  status.Update(session_options.status());
  if (status.ok()) {
    Request one;
    one.count = 1;
    status = CheckResponseFits(one, session_options->encoding,
                               static_cast<int64_t>(options->observation_format.bytes()),
                               supervisor_->limits().response_bytes_max);
  }
  if (status.ok() && options->level_sampler != nullptr) {
    status = Hold(&options->level_sampler);
  }
  if (!status.ok()) {
    RespondWith(status);
    return;
  }
  supervisor_->Create(
      owner_, start.pool_id(), *options, *session_options,
      [weak = weak_from_this()](const absl::Status& reason) {
        if (const auto self = weak.lock(); self != nullptr) {
          self->on_end_(reason);
        }
      },
      [self = shared_from_this(), &start](absl::StatusOr<std::shared_ptr<PoolSession>> pool) {
        if (pool.ok()) {
          self->pool_ = *std::move(pool);
          self->OnCreated(start);
        } else {
          self->RespondWith(pool.status());
        }
      });
}

void PoolRun::OnCreated(const v1::StartPool& start) {
  builder_.emplace(*pool_);
  // A drain may have ended all streams before the pool was listed.
  if (supervisor_->draining()) {
    RespondWith(PoolSupervisor::Draining());
  } else if (start.states().empty()) {
    RespondStarted();
  } else {
    Restore(start.states(), [this](const absl::Status& status) {
      if (status.ok()) {
        RespondStarted();
      } else {
        RespondWith(status);
      }
    });
  }
}

void PoolRun::RespondStarted() {
  v1::Started* started = response_.mutable_started();
  *started->mutable_pool() = PoolMessageOf(*pool_);
  started->set_server_version(PROCGEN_SERVER_VERSION);
  started->set_art_fingerprint(supervisor_->art_fingerprint());
  RespondWith(Serialized(response_));
}

absl::Status PoolRun::Hold(std::shared_ptr<const LevelSampler>* sampler) const {
  auto held = HoldSampler(owner_, std::move(*sampler), &supervisor_->quotas());
  if (!held.ok()) {
    *sampler = nullptr;
    return held.status();
  }
  *sampler = *std::move(held);
  return absl::OkStatus();
}

void PoolRun::ExecuteBatch(const v1::RunPoolRequest& message, absl::Time arrival_time) {
  absl::Status status = ReadRequest(message, &memory_);
  Request* const request = &memory_.request;
  if (status.ok() && request->kind == Request::Kind::kSample) {
    status = Hold(&request->level_sampler);
  } else if (status.ok()) {
    status = CheckResponseFits(*request, pool_->encoding(), pool_->observation_bytes(),
                               supervisor_->limits().response_bytes_max);
  }
  if (!status.ok()) {
    RespondWith(status);
    return;
  }
  request->arrival_time = arrival_time;
  pool_->Execute(request, shared_from_this());
}

Batch PoolRun::Prepare() { return HasValues() ? builder_->Prepare(memory_.request) : Batch(); }

void PoolRun::Done(const absl::Status& status) {
  if (status.ok() && HasValues()) {
    RespondWith(builder_->Finish());
  } else {
    RespondAck(status);
  }
}

void PoolRun::Save(const v1::SaveEnvironments& message) {
  saved_.assign(message.environments().begin(), message.environments().end());
  if (saved_.empty()) {
    saved_.resize(static_cast<size_t>(pool_->env_count()));
    std::iota(saved_.begin(), saved_.end(), 0);
  }
  if (absl::Status status = CheckEnvironmentList({.list = "environments", .environments = saved_},
                                                 pool_->name(), pool_->env_count());
      !status.ok()) {
    RespondWith(status);
    return;
  }
  InTurn([this] {
    pool_->SaveStates(
        saved_, [self = shared_from_this()](absl::StatusOr<std::vector<std::string>> snapshots) {
          self->pool_->EndTurn();
          self->RespondStates(std::move(snapshots));
        });
  });
}

void PoolRun::RespondStates(absl::StatusOr<std::vector<std::string>> snapshots) {
  if (!snapshots.ok()) {
    RespondWith(snapshots.status());
    return;
  }
  v1::States* const states = response_.mutable_states();
  for (size_t i = 0; i < saved_.size(); ++i) {
    v1::State* const state = states->add_states();
    state->set_environment(saved_[i]);
    state->set_snapshot(std::move((*snapshots)[i]));
  }
  const auto bytes = static_cast<int64_t>(response_.ByteSizeLong());
  if (const int64_t bytes_max = supervisor_->limits().response_bytes_max; bytes > bytes_max) {
    RespondWith(absl::ResourceExhaustedError(absl::StrCat("the snapshots take ", bytes,
                                                          " bytes, limit response_bytes_max is ",
                                                          bytes_max, "; save fewer environments")));
    return;
  }
  RespondWith(Serialized(response_));
}

void PoolRun::Restore(const google::protobuf::RepeatedPtrField<v1::State>& states,
                      PoolSession::Done done) {
  std::vector<StateToRestore> restored;
  saved_.clear();
  for (const v1::State& state : states) {
    saved_.push_back(state.environment());
    restored.push_back({.environment = state.environment(), .snapshot = state.snapshot()});
  }
  if (absl::Status status =
          CheckEnvironmentList({.list = "states", .member = ".environment", .environments = saved_},
                               pool_->name(), pool_->env_count());
      !status.ok()) {
    done(status);
    return;
  }
  InTurn([this, restored = std::move(restored), done = std::move(done)]() mutable {
    pool_->RestoreStates(std::move(restored), [self = shared_from_this(), done = std::move(done)](
                                                  const absl::Status& status) mutable {
      self->pool_->EndTurn();
      done(status);
    });
  });
}

void PoolRun::Clone(const v1::CloneEnvironments& message) {
  std::vector<StateToClone> pairs;
  std::vector<int32_t> sources;
  std::vector<int32_t> targets;
  for (const v1::ClonePair& pair : message.pairs()) {
    pairs.push_back({.source_environment = pair.source_environment(),
                     .target_environment = pair.target_environment()});
    sources.push_back(pair.source_environment());
    targets.push_back(pair.target_environment());
  }
  absl::Status status = CheckEnvironmentList(
      {.list = "pairs", .member = ".target_environment", .environments = targets}, pool_->name(),
      pool_->env_count());
  if (status.ok()) {
    status = CheckEnvironmentList({.list = "pairs",
                                   .member = ".source_environment",
                                   .environments = sources,
                                   .repeats_allowed = true},
                                  pool_->name(), pool_->env_count());
  }
  if (!status.ok()) {
    RespondWith(status);
    return;
  }
  InTurn([this, pairs = std::move(pairs)]() mutable {
    pool_->CloneStates(std::move(pairs), [self = shared_from_this()](const absl::Status& cloned) {
      self->pool_->EndTurn();
      self->RespondAck(cloned);
    });
  });
}

void PoolRun::Render(const v1::Render& message) {
  if (absl::Status status = CheckRender(message, *pool_, supervisor_->limits()); !status.ok()) {
    RespondWith(status);
    return;
  }
  const RenderSpec spec = RenderSpecOf(message);
  std::vector<int32_t> environments(message.environments().begin(), message.environments().end());
  InTurn([this, environments = std::move(environments), spec, &message]() mutable {
    FillFrames(environments, spec);
    if (message.format() == v1::FRAME_FORMAT_NONE) {
      pool_->EndTurn();
      RespondWith(Serialized(response_));
      return;
    }
    pool_->CaptureScenes(std::move(environments), spec.view, spec.size_px,
                         [self = shared_from_this(), &message](absl::StatusOr<Draw> draw) {
                           self->pool_->EndTurn();
                           if (!draw.ok()) {
                             self->RespondWith(draw.status());
                             return;
                           }
                           self->supervisor_->executor().Run(
                               self->owner_, [self, &message, draw = *std::move(draw)]() mutable {
                                 self->RespondFrames(message.format(), std::move(draw));
                               });
                         });
  });
}

void PoolRun::FillFrames(absl::Span<const int32_t> environments, const RenderSpec& spec) {
  v1::Frames* const frames = response_.mutable_frames();
  for (const int32_t environment : environments) {
    v1::Frame* const frame = frames->add_frames();
    frame->set_environment(environment);
    frame->set_size_px(spec.size_px);
    if (spec.view == View::kLevel) {
      const AgentPosition position = pool_->FindAgent(environment);
      frame->mutable_agent_position()->set_x(position.x);
      frame->mutable_agent_position()->set_y(position.y);
    }
  }
}

void PoolRun::RespondFrames(v1::FrameFormat format, Draw draw) {
  std::vector<absl::Span<uint8_t>> images;
  v1::Frames* const frames = response_.mutable_frames();
  for (v1::Frame& frame : *frames->mutable_frames()) {
    const auto size_px = static_cast<size_t>(frame.size_px());
    std::string* const image = frame.mutable_image();
    image->resize(size_px * size_px * 3);
    images.push_back(absl::MakeSpan(reinterpret_cast<uint8_t*>(image->data()), image->size()));
  }
  draw(images);
  WriteFrames(format, frames->mutable_frames());
  RespondWith(Serialized(response_));
}

void PoolRun::InTurn(absl::AnyInvocable<void()> begin) {
  pool_->TakeTurn(
      [self = shared_from_this(), begin = std::move(begin)](const absl::Status& turn) mutable {
        if (turn.ok()) {
          begin();
        } else {
          self->RespondWith(turn);
        }
      });
}

void PoolRun::RespondAck(const absl::Status& status) {
  if (!status.ok()) {
    RespondWith(status);
    return;
  }
  response_.mutable_ack();
  RespondWith(Serialized(response_));
}

void PoolRun::RespondWith(absl::StatusOr<grpc::ByteBuffer> response) {
  // Frees large responses; a new request may begin in `respond`.
  v1::RunPoolResponse().Swap(&response_);
  Respond respond = std::move(respond_);
  respond_ = nullptr;
  respond(std::move(response));
}

}  // namespace procgen
