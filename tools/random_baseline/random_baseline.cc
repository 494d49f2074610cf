#include "tools/random_baseline/random_baseline.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "envcore/pool/worker_pool.h"
#include "envcore/random/random_stream.h"

namespace procgen {
namespace {

// Sums over the counted episodes.
class EpisodeSums {
 public:
  explicit EpisodeSums(const RandomPlay& play)
      : episodes_per_environment_(play.episodes_per_environment),
        episode_counts_(static_cast<size_t>(play.env_count)) {}

  // Records that environment `index` has ended an episode.
  void Add(size_t index, float episode_return, int32_t length) {
    if (episode_counts_[index] == episodes_per_environment_) {
      return;
    }
    ++episode_counts_[index];
    ++count_;
    const double value = episode_return;
    return_sum_ += value;
    square_sum_ += value * value;
    length_sum_ += length;
  }

  int64_t count() const { return count_; }
  bool IsComplete() const {
    return count_ == static_cast<int64_t>(episode_counts_.size()) * episodes_per_environment_;
  }

  ReturnStatistics Statistics() const {
    const auto count = static_cast<double>(count_);
    const double mean = return_sum_ / count;
    const double variance = std::max(0.0, square_sum_ / count - mean * mean);
    return {.episode_count = count_,
            .return_mean = mean,
            .return_error = count_ > 1 ? std::sqrt(variance / (count - 1)) : 0,
            .length_mean = static_cast<double>(length_sum_) / count};
  }

 private:
  const int32_t episodes_per_environment_;
  std::vector<int32_t> episode_counts_;  // counted episodes, by environment
  int64_t count_ = 0;
  double return_sum_ = 0;
  double square_sum_ = 0;
  int64_t length_sum_ = 0;
};

}  // namespace

absl::StatusOr<ReturnStatistics> PlayRandomly(const GameMode& game_mode, const RandomPlay& play,
                                              absl::FunctionRef<void(int64_t)> show) {
  PoolOptions options;
  options.games = {std::string(game_mode.game->name)};
  options.env_count = play.env_count;
  options.environment.distribution_mode = game_mode.mode;
  options.environment.rand_seed = play.seed;
  const auto pool = Pool::Create(options, std::make_shared<WorkerPool>(play.worker_count - 1));
  if (!pool.ok()) {
    return pool.status();
  }
  const auto env_count = static_cast<size_t>(play.env_count);
  std::vector<int32_t> actions(env_count);
  std::vector<uint8_t> first(env_count);
  std::vector<float> episode_returns(env_count);
  std::vector<int32_t> episode_lengths(env_count);
  Batch batch;
  batch.first = absl::MakeSpan(first);
  batch.episode_returns = absl::MakeSpan(episode_returns);
  batch.episode_lengths = absl::MakeSpan(episode_lengths);
  RandomStream random(play.seed);
  EpisodeSums sums(play);
  while (!sums.IsComplete()) {
    for (int32_t& action : actions) {
      action = random.Int(kActionCount);
    }
    const StepInput input = {.first = 0, .count = play.env_count, .actions = actions};
    if (absl::Status status = (*pool)->Step(input, batch); !status.ok()) {
      return status;
    }
    const int64_t count_before = sums.count();
    for (size_t i = 0; i < env_count; ++i) {
      if (first[i] != 0) {
        sums.Add(i, episode_returns[i], episode_lengths[i]);
      }
    }
    if (sums.count() != count_before) {
      show(sums.count());
    }
  }
  return sums.Statistics();
}

}  // namespace procgen
