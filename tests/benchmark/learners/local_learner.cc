#include "tests/benchmark/learners/local_learner.h"

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
    : pool_(std::move(pool)),
      actions_(pool_->env_count()),
      answers_(static_cast<size_t>(local_case.batch_count)),
      answers_all_(local_case.answers_all) {
  const size_t bytes = static_cast<size_t>(pool_->env_count()) * kObservationBytes;
  for (Answer& answer : answers_) {
    answer.observations.resize(local_case.drawn ? bytes : 0);
    answer.numbers.ReplaceEmptyArrays({}, pool_->env_count());
  }
}

Batch LocalLearner::BatchIn(Answer* answer) const {
  Batch batch;
  batch.observations = absl::MakeSpan(answer->observations);
  if (answers_all_) {
    return answer->numbers.ReplaceEmptyArrays(batch, pool_->env_count());
  }
  batch.rewards = absl::MakeSpan(answer->numbers.rewards);
  batch.first = absl::MakeSpan(answer->numbers.first);
  return batch;
}

absl::Status LocalLearner::Step() {
  const StepInput input = {.first = 0, .count = pool_->env_count(), .actions = actions_.Next()};
  return pool_->Step(input, BatchIn(&answers_[++step_ % answers_.size()]));
}

}  // namespace procgen
