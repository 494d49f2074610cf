#include "server/pool/pool_observers.h"

#include <algorithm>
#include <set>
#include <utility>

namespace procgen {
namespace {

// The states that restored snapshots leave environments in.
std::vector<EpisodeLog::RestoredState> RestoredStatesOf(const std::vector<StateToRestore>& states) {
  std::vector<EpisodeLog::RestoredState> restored;
  for (const StateToRestore& state : states) {
    const absl::StatusOr<SavedEpisode> moment = ReadSavedMoment(state.snapshot);
    if (moment.ok()) {
      restored.push_back({.environment = state.environment,
                          .options = std::make_shared<const EnvironmentOptions>(moment->options),
                          .level_seed = moment->level_seed,
                          .episode_length = moment->episode_length,
                          .awaits_episode = moment->awaits_episode,
                          // A new environment has drawn one level.
                          .prev_level_incomplete = moment->level_draws != 1});
    }
  }
  return restored;
}

}  // namespace

PoolObservers::PoolObservers(const PoolOptions& options, const PoolContext& context)
    : step_count_(context.step_count),
      counts_(options, context.metrics, context.episode_bytes),
      episodes_(context.episode_bytes->bytes_max() == 0
                    ? nullptr
                    : std::make_unique<EpisodeLog>(options.env_count, context.episode_bytes)) {}

void PoolObservers::SelectFinalScenes(int32_t first, int32_t count,
                                      std::vector<FinalScene>* selected) {
  if (!has_observers_) {
    return;
  }
  absl::MutexLock lock(&observers_mutex_);
  auto each =
      std::lower_bound(final_scene_environments_.begin(), final_scene_environments_.end(), first);
  for (; each != final_scene_environments_.end() && *each < first + count; ++each) {
    selected->push_back({.environment = *each, .scene = nullptr});
  }
}

void PoolObservers::OnExecuted(const Request& request, const StepInput& input, const Batch& batch,
                               int64_t request_count) {
  if (request.kind != Request::Kind::kObserve && episodes_ != nullptr) {
    episodes_->Add(input, batch, {request.annotations, request.first, request.count});
  }
  if (input.steps) {
    *step_count_ += counts_.Add(input, batch, episodes_.get());
  }
  if (!has_observers_) {
    return;
  }
  absl::MutexLock lock(&observers_mutex_);
  for (const std::shared_ptr<PoolObserver>& observer : observers_) {
    observer->OnExecuted(request, input, batch, request_count, change_number_);
  }
}

void PoolObservers::OnRestore(const std::vector<StateToRestore>& states) {
  if (episodes_ != nullptr) {
    episodes_->Add(RestoredStatesOf(states));
  }
}

void PoolObservers::OnClone(const std::vector<StateToClone>& pairs) {
  if (episodes_ != nullptr) {
    episodes_->Add(pairs);
  }
}

void PoolObservers::OnInvalidated() {
  if (!has_observers_) {
    return;
  }
  absl::MutexLock lock(&observers_mutex_);
  for (const std::shared_ptr<PoolObserver>& observer : observers_) {
    observer->OnInvalidated();
  }
}

void PoolObservers::UpdateFinalSceneEnvironments() {
  std::set<int32_t> environments;
  for (const std::shared_ptr<PoolObserver>& observer : observers_) {
    const absl::Span<const int32_t> needed = observer->final_scene_environments();
    environments.insert(needed.begin(), needed.end());
  }
  final_scene_environments_.assign(environments.begin(), environments.end());
}

absl::Status PoolObservers::AddObserver(std::shared_ptr<PoolObserver> observer) {
  absl::MutexLock lock(&observers_mutex_);
  if (observers_end_.ok()) {
    observers_.push_back(std::move(observer));
    UpdateFinalSceneEnvironments();
    has_observers_ = true;
  }
  return observers_end_;
}

void PoolObservers::RemoveObserver(const PoolObserver* observer) {
  absl::MutexLock lock(&observers_mutex_);
  std::erase_if(observers_, [observer](const std::shared_ptr<PoolObserver>& each) {
    return each.get() == observer;
  });
  UpdateFinalSceneEnvironments();
  has_observers_ = !observers_.empty();
}

void PoolObservers::EndObservers(const absl::Status& reason) {
  std::vector<std::shared_ptr<PoolObserver>> observers;
  {
    absl::MutexLock lock(&observers_mutex_);
    observers.swap(observers_);
    observers_end_.Update(reason);
    UpdateFinalSceneEnvironments();
    has_observers_ = false;
  }
  for (const std::shared_ptr<PoolObserver>& observer : observers) {
    observer->OnEnd(reason);
  }
}

}  // namespace procgen
