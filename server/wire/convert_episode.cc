#include "server/wire/convert_episode.h"

#include <limits>
#include <utility>

#include "server/wire/convert_pool.h"
#include "server/wire/enum_value.h"

namespace procgen {
namespace {

constexpr std::pair<v1::EpisodeOutcome, EpisodeOutcome> kOutcomes[] = {
    {v1::EPISODE_OUTCOME_UNDER_WAY, EpisodeOutcome::kUnderWay},
    {v1::EPISODE_OUTCOME_TERMINATED, EpisodeOutcome::kTerminated},
    {v1::EPISODE_OUTCOME_TRUNCATED, EpisodeOutcome::kTruncated},
    {v1::EPISODE_OUTCOME_RESET, EpisodeOutcome::kReset}};
constexpr std::pair<v1::IncompleteReason, IncompleteReason> kReasons[] = {
    {v1::INCOMPLETE_REASON_STATE_RESTORED, IncompleteReason::kStateRestored},
    {v1::INCOMPLETE_REASON_TOO_OLD, IncompleteReason::kTooOld}};

// Returns the environment's options, restricted to the episode's first level.
EnvironmentOptions OptionsFor(const Episode& episode, const PoolOptions& pool) {
  EnvironmentOptions options = episode.options != nullptr ? *episode.options : pool.environment;
  if (options.distribution_mode == DistributionMode::kExploration) {
    options.distribution_mode = DistributionMode::kHard;  // exploration is hard mode with one level
  }
  const bool can_start_there = episode.level_seed >= 0 && episode.level_seed < INT32_MAX;
  options.num_levels = can_start_there ? 1 : 0;
  options.start_level = can_start_there ? episode.level_seed : 0;
  return options;
}

// Adds rows to the last of `step_count` steps.
void FillAnnotations(const AnnotationSeries& series, size_t step_count,
                     v1::AnnotationSeries* message) {
  message->set_name(series.name);
  message->set_value_count(series.value_count);
  message->set_first_step(series.first_step);
  message->mutable_values()->Add(series.values.begin(), series.values.end());
  const size_t rows = step_count - static_cast<size_t>(series.first_step);
  message->mutable_values()->Resize(
      static_cast<int>(rows * static_cast<size_t>(series.value_count)),
      std::numeric_limits<float>::quiet_NaN());
}

}  // namespace

void FillEpisode(const Episode& episode, const PoolOptions& pool, int32_t environment,
                 v1::Episode* message) {
  const auto number = static_cast<size_t>(pool.first_env) + static_cast<size_t>(environment);
  message->set_environment(environment);
  message->set_game(pool.games[number % pool.games.size()]);
  *message->mutable_options() = EnvironmentOptionsMessageOf(OptionsFor(episode, pool));
  message->set_level_seed(episode.level_seed);
  message->set_actions(episode.actions);
  message->mutable_rewards()->Add(episode.rewards.begin(), episode.rewards.end());
  message->mutable_action_counts()->Add(episode.action_counts.begin(), episode.action_counts.end());
  message->set_total_reward(episode.total_reward);
  for (const LevelChange& change : episode.level_changes) {
    v1::LevelChange* level_change = message->add_level_changes();
    level_change->set_action(change.action);
    level_change->set_level_seed(change.level_seed);
  }
  for (const AnnotationSeries& series : episode.annotations) {
    FillAnnotations(series, episode.rewards.size(), message->add_annotations());
  }
  message->set_outcome(EnumOf(kOutcomes, episode.outcome));
  message->set_level_complete(episode.level_complete);
  message->set_fingerprint(static_cast<int64_t>(episode.fingerprint));
  message->set_prev_level_incomplete(episode.prev_level_incomplete);
  message->set_incomplete_reason(EnumOf(kReasons, episode.incomplete_reason));
}

void FillEpisodeList(const RecentEpisodes::List& list, v1::ListEpisodesResponse* message) {
  for (const EndedEpisode& episode : list.episodes) {
    v1::EpisodeSummary* const added = message->add_episodes();
    added->set_environment(episode.environment);
    added->set_level_seed(episode.level_seed);
    added->set_total_reward(episode.total_reward);
    added->set_length(episode.length);
    added->set_level_complete(episode.level_complete);
    added->set_truncated(episode.is_truncated);
    added->set_fingerprint(static_cast<int64_t>(episode.fingerprint));
    FillTimestamp(episode.end_time, added->mutable_end_time());
  }
  message->set_episode_count(list.count);
  message->set_recorded_count(list.recorded_count);
}

}  // namespace procgen
