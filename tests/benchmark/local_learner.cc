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
  LocalLearner learner(*std::move(pool), course);
  for (int step = 0; step < kWarmUpSteps; ++step) {
    if (absl::Status status = learner.Step(); !status.ok()) {
      return status;
    }
  }
  return learner;
}

LocalLearner::Answer::Answer(const Course& course, size_t env_count)
    : observations(course.drawn ? env_count * kObservationBytes : 0),
      rewards(env_count),
      first(env_count) {
  const size_t count = course.answers_all ? env_count : 0;
  terminated.resize(count);
  truncated.resize(count);
  level_seeds.resize(count);
  prev_level_seeds.resize(count);
  prev_level_complete.resize(count);
  episode_returns.resize(count);
  episode_lengths.resize(count);
  fingerprints.resize(count);
}

Batch LocalLearner::Answer::AsBatch() {
  Batch batch;
  batch.observations = absl::MakeSpan(observations);
  batch.rewards = absl::MakeSpan(rewards);
  batch.first = absl::MakeSpan(first);
  batch.terminated = absl::MakeSpan(terminated);
  batch.truncated = absl::MakeSpan(truncated);
  batch.level_seeds = absl::MakeSpan(level_seeds);
  batch.prev_level_seeds = absl::MakeSpan(prev_level_seeds);
  batch.prev_level_complete = absl::MakeSpan(prev_level_complete);
  batch.episode_returns = absl::MakeSpan(episode_returns);
  batch.episode_lengths = absl::MakeSpan(episode_lengths);
  batch.fingerprints = absl::MakeSpan(fingerprints);
  return batch;
}

LocalLearner::LocalLearner(std::unique_ptr<Pool> pool, const Course& course)
    : pool_(std::move(pool)),
      actions_(pool_->env_count()),
      answers_(static_cast<size_t>(course.batch_count),
               Answer(course, static_cast<size_t>(pool_->env_count()))) {}

absl::Status LocalLearner::Step() {
  const StepInput input = {.first = 0, .count = pool_->env_count(), .actions = actions_.Next()};
  return pool_->Step(input, answers_[++step_ % answers_.size()].AsBatch());
}

}  // namespace procgen
