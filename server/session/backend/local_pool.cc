#include "server/session/backend/local_pool.h"

#include <map>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// Up to so many environments are captured faster here than on the background executor.
constexpr size_t kScenesHereMax = 64;

}  // namespace

// A free list of renderers, so that their memory is reused. Threads: any method from any thread.
class LocalPool::Renderers {
 public:
  std::unique_ptr<SceneSnapshotRenderer> Take() {
    {
      absl::MutexLock lock(&mutex_);
      if (idle_ != nullptr) {
        return std::move(idle_);
      }
    }
    return std::make_unique<SceneSnapshotRenderer>();
  }
  void PutBack(std::unique_ptr<SceneSnapshotRenderer> renderer) {
    absl::MutexLock lock(&mutex_);
    idle_.swap(renderer);
  }

 private:
  absl::Mutex mutex_;
  std::unique_ptr<SceneSnapshotRenderer> idle_ ABSL_GUARDED_BY(mutex_);
};

LocalPool::LocalPool(std::unique_ptr<Pool> pool, std::string owner, BackgroundExecutor* executor)
    : pool_(std::move(pool)),
      owner_(std::move(owner)),
      executor_(executor),
      renderers_(std::make_shared<Renderers>()) {}

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

void LocalPool::CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                              CaptureDone done) {
  if (environments.size() <= kScenesHereMax) {
    CaptureScenesHere(environments, view, size_px, std::move(done));
    return;
  }
  executor_->Run(owner_, [this, environments, view, size_px, done = std::move(done)]() mutable {
    CaptureScenesHere(environments, view, size_px, std::move(done));
  });
}

void LocalPool::CaptureScenesHere(const std::vector<int32_t>& environments, View view,
                                  int32_t size_px, CaptureDone done) {
  std::vector<SceneSnapshot> scenes;
  std::map<int32_t, size_t> places;  // in scenes, by environment
  std::vector<size_t> shown;         // places in the order of `environments`
  for (const int32_t environment : environments) {
    const auto [place, is_another] = places.emplace(environment, scenes.size());
    shown.push_back(place->second);
    if (!is_another) {
      continue;
    }
    absl::StatusOr<SceneSnapshot> scene =
        pool_->CaptureScene(environment, /*whole_level=*/view == View::kLevel);
    if (!scene.ok()) {
      done(scene.status());
      return;
    }
    scenes.push_back(*std::move(scene));
  }
  done(Draw([scenes = std::move(scenes), shown = std::move(shown), view, size_px,
             renderers = renderers_](const std::vector<absl::Span<uint8_t>>& frames) {
    std::unique_ptr<SceneSnapshotRenderer> renderer = renderers->Take();
    for (size_t i = 0; i < frames.size(); ++i) {
      if (view == View::kAgent) {
        renderer->DrawAgentView(scenes[shown[i]], frames[i]);
      } else {
        renderer->DrawHumanView(scenes[shown[i]], size_px, frames[i]);
      }
    }
    renderers->PutBack(std::move(renderer));
  }));
}

LocalPoolFactory::LocalPoolFactory(int32_t worker_count, std::shared_ptr<const SharedArt> art,
                                   BackgroundExecutor* executor)
    : workers_(std::make_shared<WorkerPool>(worker_count)),
      art_(std::move(art)),
      executor_(executor) {}

void LocalPoolFactory::Create(const CreatePoolOptions& create_options, CreateDone done) {
  executor_->Run(
      create_options.owner, [this, drawn = create_options.options, owner = create_options.owner,
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
