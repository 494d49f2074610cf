#include "tests/benchmark/local_learner.h"

#include <utility>

#include "absl/types/span.h"
#include "envcore/pool/worker_pool.h"

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
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(course.worker_count - 1));
  if (!pool.ok()) {
    return pool.status();
  }
  LocalLearner learner(*std::move(pool), course);
  for (int step = 0; step < kWarmUpSteps; ++step) {
    if (absl::Status status = learner.Step(); !status.ok()) {
      return status;
    }
  }
  return learner;
}

LocalLearner::LocalLearner(std::unique_ptr<Pool> pool, const Course& course)
    : pool_(std::move(pool)),
      actions_(pool_->env_count()),
      answers_(static_cast<size_t>(course.batch_count)),
      answers_all_(course.answers_all) {
  const size_t bytes = static_cast<size_t>(pool_->env_count()) * kObservationBytes;
  for (Answer& answer : answers_) {
    answer.observations.resize(course.drawn ? bytes : 0);
    answer.numbers.LendTo({}, pool_->env_count());
  }
}

Batch LocalLearner::BatchIn(Answer* answer) const {
  Batch batch;
  batch.observations = absl::MakeSpan(answer->observations);
  if (answers_all_) {
    return answer->numbers.LendTo(batch, pool_->env_count());
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
