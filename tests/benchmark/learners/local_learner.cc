#include "tests/benchmark/learners/local_learner.h"

#include <cstddef>
#include <utility>

#include "absl/types/span.h"
#include "envcore/pool/worker_pool.h"

namespace procgen {
namespace {

constexpr int kWarmUpSteps = 100;

}  // namespace

absl::StatusOr<LocalLearner> LocalLearner::Start(const LocalCase& local_case, int32_t env_count) {
  PoolOptions options;
  options.games = {local_case.game};
  options.env_count = env_count;
  options.environment.distribution_mode = local_case.mode;
  options.art = local_case.art;
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(local_case.worker_count - 1));
  if (!pool.ok()) {
    return pool.status();
  }
  LocalLearner learner(*std::move(pool), local_case);
  for (int step = 0; step < kWarmUpSteps; ++step) {
    if (absl::Status status = learner.Step(); !status.ok()) {
      return status;
    }
  }
  return learner;
}

LocalLearner::LocalLearner(std::unique_ptr<Pool> pool, const LocalCase& local_case)
    : pool_(std::move(pool)), actions_(pool_->env_count()) {
  observations_.resize(local_case.drawn ? pool_->env_count() * size_t{kObservationBytes} : 0);
  numbers_.ReplaceEmptyArrays({}, pool_->env_count());
}

absl::Status LocalLearner::Step() {
  Batch batch;
  batch.observations = absl::MakeSpan(observations_);
  batch.rewards = absl::MakeSpan(numbers_.rewards);
  batch.first = absl::MakeSpan(numbers_.first);
  return pool_->Step({.first = 0, .count = pool_->env_count(), .actions = actions_.Next()}, batch);
}

}  // namespace procgen
