#include "server/session/local_pool.h"

#include <string>
#include <utility>

namespace procgen {

LocalPool::LocalPool(std::unique_ptr<Pool> pool, SideCrew* side_crew)
    : pool_(std::move(pool)), side_crew_(side_crew) {}

void LocalPool::StepAsync(const StepInput& part, const Batch& batch, Done done) {
  pool_->StepAsync(part, batch, std::move(done));
}

void LocalPool::SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) {
  side_crew_->Run([this, sampler = std::move(level_sampler), done = std::move(done)]() mutable {
    done(pool_->SetLevelSampler(std::move(sampler)));
  });
}

void LocalPool::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  side_crew_->Run([this, environments, take = std::move(take), done = std::move(done)]() mutable {
    absl::Status status;
    for (const int32_t environment : environments) {
      absl::StatusOr<std::vector<std::string>> snapshots = pool_->SaveStates({environment});
      status = snapshots.status();
      if (!status.ok() || !take(environment, std::move(snapshots->front()))) {
        break;
      }
    }
    done(std::move(status));
  });
}

void LocalPool::RestoreStates(std::vector<StateToRestore> states, Done done) {
  side_crew_->Run([this, states = std::move(states), done = std::move(done)]() mutable {
    done(pool_->RestoreStates(states));
  });
}

void LocalPool::CloneStates(std::vector<StateToClone> pairs, Done done) {
  side_crew_->Run([this, pairs = std::move(pairs), done = std::move(done)]() mutable {
    done(pool_->CloneStates(pairs));
  });
}

void LocalPool::Render(absl::Span<const int32_t> environments, int32_t side_px,
                       std::vector<absl::Span<uint8_t>> frames, Done done) {
  side_crew_->Run(
      [this, environments, side_px, frames = std::move(frames), done = std::move(done)]() mutable {
        absl::Status status;
        for (size_t i = 0; i < environments.size() && status.ok(); ++i) {
          status = pool_->Render(environments[i], side_px, frames[i]);
        }
        done(std::move(status));
      });
}

LocalPoolHost::LocalPoolHost(int32_t worker_count, std::shared_ptr<const SharedArt> art,
                             SideCrew* side_crew)
    : crew_(std::make_shared<Crew>(worker_count)), art_(std::move(art)), side_crew_(side_crew) {}

void LocalPoolHost::Create(const PoolOrder& order, CreateDone done) {
  side_crew_->Run([this, drawn = order.options, done = std::move(done)]() mutable {
    drawn.art = art_;
    absl::StatusOr<std::unique_ptr<Pool>> pool = Pool::Create(drawn, crew_);
    if (pool.ok()) {
      done(std::make_unique<LocalPool>(*std::move(pool), side_crew_));
    } else {
      done(pool.status());
    }
  });
}

}  // namespace procgen
