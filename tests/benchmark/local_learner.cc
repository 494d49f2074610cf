#include "tests/benchmark/local_learner.h"

#include <utility>

#include "absl/types/span.h"
#include "envcore/pool/crew.h"

namespace procgen {
namespace {

constexpr int kWarmUpSteps = 100;

}  // namespace

absl::StatusOr<LocalLearner> LocalLearner::Start(const Course& course, int32_t env_count) {
  PoolOptions options;
  options.games = {course.game};
  options.env_count = env_count;
  options.environment.distribution_mode = course.mode;
  options.art = course.art;
  auto pool = Pool::Create(options, std::make_shared<Crew>(course.worker_count - 1));
  if (!pool.ok()) {
    return pool.status();
  }
  LocalLearner learner(*std::move(pool), course.drawn);
  for (int step = 0; step < kWarmUpSteps; ++step) {
    if (absl::Status status = learner.Step(); !status.ok()) {
      return status;
    }
  }
  return learner;
}

LocalLearner::LocalLearner(std::unique_ptr<Pool> pool, bool drawn)
    : pool_(std::move(pool)),
      actions_(pool_->env_count()),
      observations_(drawn ? static_cast<size_t>(pool_->env_count()) * kObservationBytes : 0),
      rewards_(static_cast<size_t>(pool_->env_count())),
      first_(static_cast<size_t>(pool_->env_count())) {}

absl::Status LocalLearner::Step() {
  const StepInput input = {.first = 0, .count = pool_->env_count(), .actions = actions_.Next()};
  Batch batch;
  batch.observations = absl::MakeSpan(observations_);
  batch.rewards = absl::MakeSpan(rewards_);
  batch.first = absl::MakeSpan(first_);
  return pool_->Step(input, batch);
}

}  // namespace procgen
