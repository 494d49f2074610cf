#include "clients/libenv/environments.h"

#include <algorithm>
#include <utility>

#include "clients/libenv/tensor_types.h"

namespace procgen {

absl::StatusOr<std::unique_ptr<Environments>> Environments::Create(const PoolOptions& options,
                                                                   int32_t num_threads) {
  const int32_t thread_count = std::min(num_threads, options.env_count);
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(thread_count));
  if (!pool.ok()) {
    return pool.status();
  }
  std::unique_ptr<Environments> environments(new Environments(*std::move(pool), thread_count > 0));
  const Batch batch = environments->OwnBatch();
  if (absl::Status status = environments->pool_->Observe(0, options.env_count, batch);
      !status.ok()) {
    return status;
  }
  return environments;
}

Environments::Environments(std::unique_ptr<Pool> pool, bool has_workers)
    : pool_(std::move(pool)),
      has_workers_(has_workers),
      actions_(static_cast<size_t>(pool_->env_count())),
      observations_(actions_.size() * kObservationBytes) {}

Environments::~Environments() { Wait().IgnoreError(); }

absl::Status Environments::Act(absl::Span<const int32_t> actions) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  actions_.assign(actions.begin(), actions.end());
  const StepInput input = {.count = pool_->env_count(), .actions = actions_};
  if (!has_workers_) {
    return pool_->Step(input, OwnBatch());
  }
  {
    absl::MutexLock lock(&mutex_);
    is_stepping_ = true;
  }
  pool_->StepAsync(input, OwnBatch(), [this](const absl::Status& status) {
    absl::MutexLock lock(&mutex_);
    is_stepping_ = false;
    status_ = status;
  });
  return absl::OkStatus();
}

absl::StatusOr<EnvironmentValues> Environments::Observe() {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  return EnvironmentValues{.observations = observations_,
                           .rewards = numbers_.rewards,
                           .first = numbers_.first,
                           .prev_level_seeds = numbers_.prev_level_seeds,
                           .prev_level_complete = numbers_.prev_level_complete,
                           .level_seeds = numbers_.level_seeds};
}

absl::Status Environments::Render(int32_t environment, absl::Span<uint8_t> frame) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  return pool_->Render(environment, kHumanViewSizePx, frame);
}

absl::StatusOr<std::string> Environments::SaveState(int32_t environment) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  auto snapshots = pool_->SaveStates({environment});
  if (!snapshots.ok()) {
    return snapshots.status();
  }
  return std::move(snapshots->front());
}

absl::Status Environments::RestoreState(int32_t environment, absl::string_view snapshot) {
  if (absl::Status status = Wait(); !status.ok()) {
    return status;
  }
  const StateToRestore state = {.environment = environment, .snapshot = snapshot};
  if (absl::Status status = pool_->RestoreStates({state}); !status.ok()) {
    return status;
  }
  return pool_->Observe(0, pool_->env_count(), OwnBatch());
}

absl::Status Environments::Wait() {
  const auto is_idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !is_stepping_; };
  absl::MutexLock lock(&mutex_, absl::Condition(&is_idle));
  return status_;
}

Batch Environments::OwnBatch() {
  Batch batch;
  batch.observations = absl::MakeSpan(observations_);
  return numbers_.ReplaceEmptyArrays(batch, pool_->env_count());
}

}  // namespace procgen
