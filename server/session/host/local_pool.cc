#include "server/session/host/local_pool.h"

#include <map>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// So many environments are looked at sooner than handed over.
constexpr size_t kLooksHereMax = 64;

}  // namespace

// Painters that nobody uses at the moment. Whoever draws takes one, and the next has its memory.
// Threads: any method from any thread.
class LocalPool::Painters {
 public:
  std::unique_ptr<SightPainter> Take() {
    {
      absl::MutexLock lock(&mutex_);
      if (idle_ != nullptr) {
        return std::move(idle_);
      }
    }
    return std::make_unique<SightPainter>();
  }
  void PutBack(std::unique_ptr<SightPainter> painter) {
    absl::MutexLock lock(&mutex_);
    idle_.swap(painter);
  }

 private:
  absl::Mutex mutex_;
  std::unique_ptr<SightPainter> idle_ ABSL_GUARDED_BY(mutex_);
};

LocalPool::LocalPool(std::unique_ptr<Pool> pool, std::string owner, BackgroundExecutor* executor)
    : pool_(std::move(pool)),
      owner_(std::move(owner)),
      executor_(executor),
      painters_(std::make_shared<Painters>()) {}

LocalPool::~LocalPool() = default;

void LocalPool::StepAsync(const StepInput& part, const Batch& batch, Done done) {
  pool_->StepAsync(part, batch, std::move(done));
}

void LocalPool::SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) {
  executor_->Run(owner_,
                 [this, sampler = std::move(level_sampler), done = std::move(done)]() mutable {
                   done(pool_->SetLevelSampler(std::move(sampler)));
                 });
}

void LocalPool::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  executor_->Run(
      owner_, [this, environments, take = std::move(take), done = std::move(done)]() mutable {
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
  executor_->Run(owner_, [this, states = std::move(states), done = std::move(done)]() mutable {
    done(pool_->RestoreStates(states));
  });
}

void LocalPool::CloneStates(std::vector<StateToClone> pairs, Done done) {
  executor_->Run(owner_, [this, pairs = std::move(pairs), done = std::move(done)]() mutable {
    done(pool_->CloneStates(pairs));
  });
}

void LocalPool::Look(const std::vector<int32_t>& environments, View view, int32_t side_px,
                     LookDone done) {
  if (environments.size() <= kLooksHereMax) {
    LookHere(environments, view, side_px, std::move(done));
    return;
  }
  executor_->Run(owner_, [this, environments, view, side_px, done = std::move(done)]() mutable {
    LookHere(environments, view, side_px, std::move(done));
  });
}

void LocalPool::LookHere(const std::vector<int32_t>& environments, View view, int32_t side_px,
                         LookDone done) {
  std::vector<Sight> sights;
  std::map<int32_t, size_t> places;  // in sights, by environment
  std::vector<size_t> shown;         // places in the order of `environments`
  for (const int32_t environment : environments) {
    const auto [place, is_another] = places.emplace(environment, sights.size());
    shown.push_back(place->second);
    if (!is_another) {
      continue;
    }
    absl::StatusOr<Sight> sight = pool_->Look(environment);
    if (!sight.ok()) {
      done(sight.status());
      return;
    }
    sights.push_back(*std::move(sight));
  }
  done(Draw([sights = std::move(sights), shown = std::move(shown), view, side_px,
             painters = painters_](const std::vector<absl::Span<uint8_t>>& frames) {
    std::unique_ptr<SightPainter> painter = painters->Take();
    for (size_t i = 0; i < frames.size(); ++i) {
      if (view == View::kAgent) {
        painter->DrawAgentView(sights[shown[i]], frames[i]);
      } else {
        painter->DrawHumanView(sights[shown[i]], side_px, frames[i]);
      }
    }
    painters->PutBack(std::move(painter));
  }));
}

LocalPoolHost::LocalPoolHost(int32_t worker_count, std::shared_ptr<const SharedArt> art,
                             BackgroundExecutor* executor)
    : workers_(std::make_shared<WorkerPool>(worker_count)),
      art_(std::move(art)),
      executor_(executor) {}

void LocalPoolHost::Create(const PoolOrder& order, CreateDone done) {
  executor_->Run(order.owner, [this, drawn = order.options, owner = order.owner,
                               done = std::move(done)]() mutable {
    drawn.art = art_;
    absl::StatusOr<std::unique_ptr<Pool>> pool = Pool::Create(drawn, workers_);
    if (pool.ok()) {
      done(std::make_unique<LocalPool>(*std::move(pool), std::move(owner), executor_));
    } else {
      done(pool.status());
    }
  });
}

}  // namespace procgen
