#include "envcore/environment/environment.h"

#include <limits>
#include <utility>

namespace procgen {
namespace {

constexpr uint32_t kSequentialLevelStep = 997;  // between the seeds of successive levels

int32_t Wrapped(uint32_t bits) { return static_cast<int32_t>(bits); }

}  // namespace

Environment::Environment(const GameSpec& spec, const EnvironmentOptions& options,
                         AutoresetMode autoreset_mode)
    : spec_(spec),
      options_(options),
      step_limit_(spec.StepLimit(options.distribution_mode)),
      autoreset_mode_(autoreset_mode),
      level_seed_low_(options.num_levels == 0 ? 0 : options.start_level),
      level_seed_high_(options.num_levels == 0
                           ? std::numeric_limits<int32_t>::max()
                           : Wrapped(static_cast<uint32_t>(options.start_level) +
                                     static_cast<uint32_t>(options.num_levels))),
      game_(spec.make(options)) {}

Environment::Environment(const GameSpec& spec, const EnvironmentOptions& options,
                         uint32_t level_stream_seed, AutoresetMode autoreset_mode,
                         std::shared_ptr<const LevelSampler> level_sampler)
    : Environment(spec, options, autoreset_mode) {
  level_stream_.Seed(level_stream_seed);
  level_sampler_ = std::move(level_sampler);
  BeginEpisode();
  result_.fingerprint = fingerprint_.value();
}

void Environment::BeginLevel(bool follows_completed) {
  if (next_level_.has_value()) {
    result_.level_seed = *next_level_;
    next_level_.reset();
  } else if (level_sampler_ != nullptr) {
    result_.level_seed = level_sampler_->Draw(level_stream_);
  } else if (follows_completed) {
    result_.level_seed = Wrapped(static_cast<uint32_t>(result_.level_seed) + kSequentialLevelStep);
  } else {
    result_.level_seed = level_stream_.Int(level_seed_low_, level_seed_high_);
  }
  game_->StartLevel(result_.level_seed);
  fingerprint_.AddLevel(result_.level_seed);
}

void Environment::BeginEpisode() {
  fingerprint_.Begin(spec_.name, options_);
  BeginLevel(/*follows_completed=*/false);
  result_.first = true;
  episode_return_ = 0;
  episode_length_ = 0;
  ended_ = false;
  edited_ = false;
}

int32_t Environment::ReadObjects(absl::Span<ObjectRow> rows) const {
  return procgen::ReadObjects(game_->world(), spec_.kinds, rows);
}

void Environment::Reset(std::optional<int32_t> level_seed, std::optional<int64_t> rand_seed) {
  if (rand_seed.has_value()) {
    SeedLevels(*rand_seed);
  }
  if (level_seed.has_value()) {
    next_level_ = level_seed;
  }
  const int32_t left_level_seed = result_.level_seed;
  result_ = StepResult();
  result_.level_seed = left_level_seed;
  result_.prev_level_seed = left_level_seed;
  BeginEpisode();
  result_.fingerprint = fingerprint_.value();
}

void Environment::Step(int32_t action, int32_t repeat, absl::FunctionRef<void()> before_new_level) {
  if (ended_) {
    Reset(std::nullopt, std::nullopt);
    return;
  }
  float reward = 0;
  for (int32_t i = 0; i < repeat; ++i) {
    StepOnce(action, before_new_level);
    reward += result_.reward;
    if (result_.first || ended_ || result_.prev_level_complete) {
      break;
    }
  }
  result_.reward = reward;
}

void Environment::StepOnce(int32_t action, absl::FunctionRef<void()> before_new_level) {
  const bool forced_end = action == kEndEpisodeAction;
  game_->Play(forced_end ? kNoAction : action);
  const StepOutcome& outcome = game_->outcome();
  const bool out_of_steps = game_->step_number() >= step_limit_;
  const bool level_over = outcome.done || forced_end || out_of_steps;
  // With sequential levels, a completed level is followed by the next one in the same episode.
  const bool goes_on = options_.use_sequential_levels && outcome.level_complete;
  const bool episode_over = level_over && !goes_on;

  episode_return_ += outcome.reward;
  ++episode_length_;
  result_.reward = outcome.reward;
  result_.first = false;
  result_.terminated = episode_over && (outcome.done || forced_end);
  result_.truncated = episode_over && !result_.terminated;
  result_.prev_level_seed = result_.level_seed;
  result_.prev_level_complete = outcome.level_complete;
  result_.episode_return = episode_return_;
  result_.episode_length = episode_length_;
  fingerprint_.AddStep(action, result_.reward, result_.prev_level_complete, result_.terminated,
                       result_.truncated);
  result_.fingerprint = fingerprint_.value();

  if (episode_over) {
    before_new_level();
    if (autoreset_mode_ == AutoresetMode::kSameStep) {
      BeginEpisode();
    } else {
      ended_ = true;
    }
  } else if (level_over) {
    BeginLevel(/*follows_completed=*/true);
    result_.fingerprint = fingerprint_.value();
  }
}

}  // namespace procgen
