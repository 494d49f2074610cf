#include "server/wire/convert_episode.h"

#include <string>

#include "absl/strings/string_view.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

v1::EpisodeOutcome OutcomeOf(EpisodeOutcome outcome) {
  switch (outcome) {
    case EpisodeOutcome::kUnderWay:
      return v1::EPISODE_OUTCOME_UNDER_WAY;
    case EpisodeOutcome::kTerminated:
      return v1::EPISODE_OUTCOME_TERMINATED;
    case EpisodeOutcome::kTruncated:
      return v1::EPISODE_OUTCOME_TRUNCATED;
    case EpisodeOutcome::kReset:
      return v1::EPISODE_OUTCOME_RESET;
  }
  return v1::EPISODE_OUTCOME_UNSPECIFIED;
}

absl::string_view ReasonOf(EpisodeLack lack) {
  switch (lack) {
    case EpisodeLack::kNothing:
      return "";
    case EpisodeLack::kStatePutIn:
      return "a state was put into the environment in the midst of the episode";
    case EpisodeLack::kTooOld:
      return "the episode began too long ago, and its beginning was forgotten (limit "
             "episode_bytes_max)";
    case EpisodeLack::kBeforeProcess:
      return "the episode began before the server was started";
    case EpisodeLack::kFailedRequest:
      return "a request failed in the midst of the episode";
  }
  return "";
}

// Those of the environment, with the episode's first level alone.
EnvironmentOptions OptionsFor(const Episode& episode, const PoolOptions& pool) {
  EnvironmentOptions options = episode.options != nullptr ? *episode.options : pool.environment;
  if (options.distribution_mode == DistributionMode::kExploration) {
    options.distribution_mode = DistributionMode::kHard;  // of one level
  }
  const bool can_start_there = episode.level_seed >= 0 && episode.level_seed < INT32_MAX;
  options.num_levels = can_start_there ? 1 : 0;
  options.start_level = can_start_there ? episode.level_seed : 0;
  return options;
}

}  // namespace

void FillEpisode(const Episode& episode, const PoolOptions& pool, int32_t environment,
                 v1::Episode* message) {
  const auto number = static_cast<size_t>(pool.first_env + environment);
  message->set_environment(environment);
  message->set_game(pool.games[number % pool.games.size()]);
  *message->mutable_options() = EnvironmentOptionsMessageOf(OptionsFor(episode, pool));
  message->set_level_seed(episode.level_seed);
  message->set_actions(episode.actions);
  message->mutable_rewards()->Add(episode.rewards.begin(), episode.rewards.end());
  message->mutable_action_counts()->Add(episode.action_counts.begin(), episode.action_counts.end());
  message->set_total_reward(episode.total_reward);
  for (const LaterLevel& later : episode.later_levels) {
    v1::LaterLevel* level = message->add_later_levels();
    level->set_action(later.action);
    level->set_level_seed(later.level_seed);
  }
  message->set_outcome(OutcomeOf(episode.outcome));
  message->set_level_complete(episode.level_complete);
  message->set_fingerprint(static_cast<int64_t>(episode.fingerprint));
  message->set_follows_another(episode.follows_another);
  message->set_incomplete_because(std::string(ReasonOf(episode.lack)));
}

}  // namespace procgen
