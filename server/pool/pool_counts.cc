#include "server/pool/pool_counts.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "absl/time/clock.h"

namespace procgen {

PoolCounts::PoolCounts(const PoolOptions& options, Metrics* metrics, ByteBudget* episode_bytes)
    : first_env_(options.first_env), episodes_(episode_bytes) {
  for (const std::string& game : options.games) {
    games_.push_back(
        metrics->OfGame(game, DistributionModeName(options.environment.distribution_mode)));
  }
  game_steps_.resize(games_.size());
}

int64_t PoolCounts::Add(const StepInput& input, const Batch& batch, const EpisodeLog* log) {
  const int64_t steps = input.count - static_cast<int64_t>(input.resets.size());
  step_count_ += steps;
  AddSteps(input);
  for (int32_t row = 0; row < input.count; ++row) {
    const auto at = static_cast<size_t>(row);
    if (batch.terminated[at] != 0 || batch.truncated[at] != 0) {
      games_[GameIndexOf(input.first + row)].AddEpisode(batch.episode_returns[at],
                                                        batch.episode_lengths[at]);
      const EndedEpisode episode = {.environment = input.first + row,
                                    .level_seed = batch.prev_level_seeds[at],
                                    .total_reward = batch.episode_returns[at],
                                    .length = batch.episode_lengths[at],
                                    .is_truncated = batch.terminated[at] == 0,
                                    .level_complete = batch.prev_level_complete[at] != 0,
                                    .fingerprint = batch.fingerprints[at],
                                    .end_time = absl::Now()};
      std::optional<EpisodeRecording> recording;
      if (log != nullptr) {
        recording = log->Read(episode.environment, /*under_way=*/false).value();
      }
      episodes_.Add(episode, std::move(recording));
    }
  }
  return steps;
}

void PoolCounts::AddSteps(const StepInput& input) {
  const auto game_count = static_cast<int32_t>(games_.size());
  // Environments row, row + game_count, ... play the same game.
  for (int32_t row = 0; row < game_count; ++row) {
    game_steps_[GameIndexOf(input.first + row)] =
        (std::max(0, input.count - row) + game_count - 1) / game_count;
  }
  for (const Reset& reset : input.resets) {
    --game_steps_[GameIndexOf(reset.environment)];
  }
  for (size_t game = 0; game < games_.size(); ++game) {
    games_[game].AddSteps(game_steps_[game]);
  }
}

size_t PoolCounts::GameIndexOf(int32_t environment) const {
  return (static_cast<size_t>(first_env_) + static_cast<size_t>(environment)) % games_.size();
}

}  // namespace procgen
