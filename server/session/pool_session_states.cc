// What a PoolSession does with states, and with what led to them.

#include <utility>

#include "server/session/pool_session.h"

namespace procgen {
namespace {

// What snapshots say of how environments go on that were put into them.
std::vector<EpisodeLog::PutIn> PutInOf(const std::vector<StateToRestore>& states) {
  std::vector<EpisodeLog::PutIn> put_in;
  for (const StateToRestore& state : states) {
    const absl::StatusOr<SavedMoment> moment = ReadSavedMoment(state.snapshot);
    if (moment.ok()) {
      put_in.push_back({.environment = state.environment,
                        .options = std::make_shared<const EnvironmentOptions>(moment->options),
                        .level_seed = moment->level_seed,
                        .episode_length = moment->episode_length,
                        .awaits_episode = moment->awaits_episode,
                        // That of a new environment has drawn one level.
                        .follows_another = moment->level_draws != 1});
    }
  }
  return put_in;
}

}  // namespace

void PoolSession::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  pool_->SaveStates(environments, std::move(take), std::move(done));
}

void PoolSession::RestoreStates(std::vector<StateToRestore> states, Done done) {
  ++change_number_;
  TellTapsOfStates();
  std::vector<StateToRestore> restored = states;
  pool_->RestoreStates(std::move(states), [this, restored = std::move(restored),
                                           done = std::move(done)](absl::Status status) mutable {
    if (status.ok() && episodes_ != nullptr) {
      episodes_->Add(PutInOf(restored));
    }
    done(std::move(status));
  });
}

void PoolSession::CloneStates(std::vector<StateToClone> pairs, Done done) {
  ++change_number_;
  TellTapsOfStates();
  std::vector<StateToClone> cloned = pairs;
  pool_->CloneStates(std::move(pairs), [this, cloned = std::move(cloned),
                                        done = std::move(done)](absl::Status status) mutable {
    if (status.ok() && episodes_ != nullptr) {
      episodes_->Add(cloned);
    }
    done(std::move(status));
  });
}

void PoolSession::ReadEpisode(int32_t environment, bool under_way, EpisodeDone done) {
  if (episodes_ == nullptr) {
    done(absl::UnimplementedError(
        "this server remembers no episodes, limit episode_bytes_max is 0"));
    return;
  }
  if (!under_way || episodes_->KnowsLevel(environment)) {
    done(episodes_->Read(environment, under_way));
    return;
  }
  // It has not been stepped yet, and says itself which level it has.
  struct Observed {
    Request request;
    std::vector<int32_t> level_seeds = {0};
    Batch batch;
  };
  auto observed = std::make_shared<Observed>();
  observed->request.first = environment;
  observed->request.count = 1;
  observed->batch.level_seeds = absl::MakeSpan(observed->level_seeds);
  pool_->BeginRequest(observed->request, observed->batch);
  pool_->StepAsync(
      {.first = environment, .count = 1, .steps = false}, observed->batch,
      [this, environment, observed, done = std::move(done)](const absl::Status& status) mutable {
        if (!status.ok()) {
          done(status);
          return;
        }
        episodes_->SetLevel(environment, observed->level_seeds.front());
        done(episodes_->Read(environment, /*under_way=*/true));
      },
      /*near_end=*/nullptr);
}

}  // namespace procgen
