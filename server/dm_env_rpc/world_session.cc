#include "server/dm_env_rpc/world_session.h"

#include <utility>

namespace procgen {
namespace {

// A request for all environments of the pool.
Request RequestOf(Request::Kind kind) {
  Request request;
  request.kind = kind;
  return request;
}

}  // namespace

WorldSession::WorldSession(std::shared_ptr<JoinedWorld> world, const WorldSignature& signature)
    : world_(std::move(world)),
      signature_(signature),
      values_(signature),
      next_(static_cast<size_t>(signature.env_count)) {}

void WorldSession::Observe(Done done) {
  world_->Run(RequestOf(Request::Kind::kObserve), values_.BatchOf({}), std::move(done));
}

void WorldSession::Step(const dm::StepRequest& request, int64_t response_bytes_max,
                        dm::StepResponse* response, Done done) {
  absl::Status status = CheckRequestedObservations(signature_, request, response_bytes_max);
  if (status.ok() && running_) {
    absl::StatusOr<std::vector<int32_t>> actions = ReadActions(signature_, request);
    status = actions.status();
    actions_ = std::move(actions).value_or(std::vector<int32_t>());
  }
  if (!status.ok()) {
    done(std::move(status));
    return;
  }
  interruptions_ = world_->TakeInterruptions();
  if (!running_) {
    Begin(request, response, std::move(done));
  } else if (!interruptions_.empty()) {
    AnswerInterrupted(request, response, std::move(done));
  } else {
    TakeActions(request, response, std::move(done));
  }
}

void WorldSession::TakeActions(const dm::StepRequest& request, dm::StepResponse* response,
                               Done done) {
  next_levels_.clear();
  for (size_t i = 0; i < next_.size(); ++i) {
    if (next_[i].level_seed.has_value()) {
      next_levels_.push_back({static_cast<int32_t>(i), *next_[i].level_seed});
    }
  }
  Request pool_request = RequestOf(Request::Kind::kStep);
  pool_request.actions = actions_;
  pool_request.next_levels = next_levels_;
  Run(pool_request, std::nullopt, request, response, std::move(done));
}

void WorldSession::AnswerInterrupted(const dm::StepRequest& request, dm::StepResponse* response,
                                     Done done) {
  Run(RequestOf(Request::Kind::kObserve), dm::INTERRUPTED, request, response, std::move(done));
}

void WorldSession::Begin(const dm::StepRequest& request, dm::StepResponse* response, Done done) {
  if (!interruptions_.empty()) {
    ApplySettings(interruptions_.back()->settings());
    reset_all_ = true;
  }
  resets_.clear();
  for (size_t i = 0; i < next_.size(); ++i) {
    const Next& next = next_[i];
    if (reset_all_ || next.level_seed.has_value() || next.rand_seed.has_value() ||
        !(next.restored || values_.first(i))) {
      resets_.push_back({static_cast<int32_t>(i), next.level_seed, next.rand_seed});
    }
  }
  Request pool_request =
      RequestOf(resets_.empty() ? Request::Kind::kObserve : Request::Kind::kReset);
  pool_request.resets = resets_;
  Run(pool_request, dm::RUNNING, request, response, std::move(done));
}

void WorldSession::Run(const Request& pool_request, std::optional<dm::EnvironmentStateType> state,
                       const dm::StepRequest& request, dm::StepResponse* response, Done done) {
  const absl::Span<uint8_t> frames = AddFrames(signature_, request, response);
  world_->Run(
      pool_request, values_.BatchOf(frames),
      [this, state, &request, response, done = std::move(done)](absl::Status status) mutable {
        OnRun(status, state, request, response);
        done(std::move(status));
      });
}

void WorldSession::OnRun(const absl::Status& status, std::optional<dm::EnvironmentStateType> state,
                         const dm::StepRequest& request, dm::StepResponse* response) {
  if (!status.ok()) {
    SettleInterruptions(Interruption::End::kLeft);
    return;
  }
  reset_all_ = state == dm::INTERRUPTED;
  if (reset_all_) {
    ApplySettings(interruptions_.back()->settings());
  } else {
    next_.assign(next_.size(), Next());
  }
  if (state.has_value()) {
    values_.ClearOutcome();
  }
  response->set_state(state.has_value() ? *state : StateAfterActions());
  running_ = response->state() == dm::RUNNING;
  values_.Fill(signature_, request, response);
  SettleInterruptions(Interruption::End::kNotified);
}

dm::EnvironmentStateType WorldSession::StateAfterActions() const {
  if (signature_.is_single && values_.terminated(0)) {
    return dm::TERMINATED;
  }
  return signature_.is_single && values_.truncated(0) ? dm::INTERRUPTED : dm::RUNNING;
}

absl::Status WorldSession::Reset(const Settings& settings) {
  const absl::StatusOr<EpisodeSettings> read = ReadEpisodeSettings(settings, signature_.shape());
  if (!read.ok()) {
    return read.status();
  }
  ApplySettings(*read);
  reset_all_ = reset_all_ || running_ || !settings.empty();
  running_ = false;
  return absl::OkStatus();
}

void WorldSession::ResetNow(const EpisodeSettings& settings, Done done) {
  struct Exchange {
    dm::StepRequest request;
    dm::StepResponse response;
  };
  ApplySettings(settings);
  reset_all_ = true;
  running_ = false;
  auto exchange = std::make_unique<Exchange>();
  Exchange* const exchanged = exchange.get();
  Begin(exchanged->request, &exchanged->response,
        [exchange = std::move(exchange), done = std::move(done)](absl::Status status) mutable {
          done(std::move(status));
        });
}

void WorldSession::ApplySettings(const EpisodeSettings& settings) {
  for (size_t i = 0; i < next_.size(); ++i) {
    if (settings.level_seeds[i].has_value()) {
      next_[i].level_seed = settings.level_seeds[i];
    }
    if (settings.rand_seeds[i].has_value()) {
      next_[i].rand_seed = settings.rand_seeds[i];
    }
  }
}

void WorldSession::SettleInterruptions(Interruption::End end) {
  for (const std::shared_ptr<Interruption>& interruption : std::exchange(interruptions_, {})) {
    interruption->Settle(end);
  }
}

void WorldSession::SetNextLevel(int32_t environment, int32_t level_seed) {
  next_[static_cast<size_t>(environment)].level_seed = level_seed;
}

void WorldSession::SaveState(int32_t environment, SaveDone done) {
  saved_environment_ = environment;
  world_->InTurn(
      [this](PoolSession* pool, Done end) {
        pool->SaveStates(
            absl::MakeConstSpan(&saved_environment_, 1),
            [this](int32_t /*environment*/, std::string snapshot) {
              saved_ = std::move(snapshot);
              return true;
            },
            std::move(end));
      },
      [this, done = std::move(done)](absl::Status status) mutable {
        if (!status.ok()) {
          done(std::move(status));
        } else {
          done(std::exchange(saved_, {}));
        }
      });
}

void WorldSession::RestoreState(int32_t environment, absl::string_view snapshot, Done done) {
  world_->InTurn(
      [this, environment, snapshot](PoolSession* pool, Done end) {
        pool->RestoreStates(
            {{.environment = environment, .snapshot = snapshot}},
            [this, pool, environment, end = std::move(end)](absl::Status status) mutable {
              if (status.ok()) {
                // A state that was saved at an episode's end continues with the next episode.
                const bool ended = pool->AwaitsReset(environment);
                Next& next = next_[static_cast<size_t>(environment)];
                next = Next();
                next.restored = !ended;
                running_ = running_ && !ended;
              }
              end(std::move(status));
            });
      },
      [this, done = std::move(done)](absl::Status status) mutable {
        if (!status.ok()) {
          done(std::move(status));
        } else {
          Observe(std::move(done));
        }
      });
}

}  // namespace procgen
