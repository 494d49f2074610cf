#include "server/web/play/recording.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "envcore/games/game_catalog.h"

namespace procgen::web {

Json FingerprintJson(std::optional<uint64_t> fingerprint) {
  if (!fingerprint.has_value()) {
    return nullptr;
  }
  return absl::StrCat(absl::Hex(*fingerprint, absl::kZeroPad16));
}

Recording::Recording(std::vector<std::string> games, const EnvironmentOptions& options) {
  trace_.games = std::move(games);
  trace_.options = options;
  trace_.env_count = 1;
}

void Recording::Begin(const Row& row) {
  Trace begun;
  begun.games = trace_.games;
  begun.options = trace_.options;
  begun.env_count = 1;
  begun.fingerprints.resize(1);
  trace_ = std::move(begun);
  episode_returns_.clear();
  episode_lengths_.clear();
  ends_.clear();
  AddRow(row);
}

void Recording::Add(int32_t action, const Row& row) {
  ++trace_.step_count;
  trace_.actions.push_back(action);
  AddRow(row);
  if (row.first) {
    ends_.push_back({trace_.step_count, row.fingerprint});
    if (row.fingerprint.has_value()) {
      trace_.fingerprints.front().push_back(*row.fingerprint);
    }
  }
}

void Recording::Truncate(int32_t row_count) {
  const auto rows = static_cast<size_t>(row_count);
  trace_.step_count = row_count - 1;
  trace_.actions.resize(rows - 1);
  trace_.rewards.resize(rows);
  trace_.first.resize(rows);
  trace_.level_seeds.resize(rows);
  trace_.prev_level_seeds.resize(rows);
  trace_.prev_level_complete.resize(rows);
  episode_returns_.resize(rows);
  episode_lengths_.resize(rows);
  trace_.fingerprints.front().clear();
  std::erase_if(ends_, [row_count](const End& end) { return end.row >= row_count; });
  for (const End& end : ends_) {
    if (end.fingerprint.has_value()) {
      trace_.fingerprints.front().push_back(*end.fingerprint);
    }
  }
}

void Recording::AddRow(const Row& row) {
  trace_.rewards.push_back(row.reward);
  trace_.first.push_back(row.first ? 1 : 0);
  trace_.level_seeds.push_back(row.level_seed);
  trace_.prev_level_seeds.push_back(row.prev_level_seed);
  trace_.prev_level_complete.push_back(row.prev_level_complete ? 1 : 0);
  episode_returns_.push_back(row.episode_return);
  episode_lengths_.push_back(row.episode_length);
}

std::optional<uint64_t> Recording::FingerprintAt(int32_t row) const {
  const auto after =
      std::upper_bound(ends_.begin(), ends_.end(), row,
                       [](int32_t wanted, const End& end) { return wanted < end.row; });
  return after == ends_.begin() ? std::nullopt : std::prev(after)->fingerprint;
}

Json Recording::ViewOf(int32_t row) const {
  const auto i = static_cast<size_t>(row);
  const auto ended =
      std::count_if(ends_.begin(), ends_.end(), [row](const End& end) { return end.row <= row; });
  return {{"step", row},
          {"reward", trace_.rewards[i]},
          {"total_reward", episode_returns_[i]},
          {"first", trace_.first[i] != 0},
          {"level_seed", trace_.level_seeds[i]},
          {"prev_level_seed", trace_.prev_level_seeds[i]},
          {"prev_level_complete", trace_.prev_level_complete[i] != 0},
          {"episode_count", ended},
          {"episode_step", episode_lengths_[i]},
          {"fingerprint", FingerprintJson(FingerprintAt(row))}};
}

Json Recording::Summary() const {
  Json first = Json::array();
  Json level_seeds = Json::array();
  Json level_complete = Json::array();
  for (size_t i = 0; i < trace_.first.size(); ++i) {
    if (trace_.first[i] != 0) {
      first.push_back(i);
    }
    if (trace_.prev_level_complete[i] != 0) {
      level_complete.push_back(i);
    }
    if (i == 0 || trace_.level_seeds[i] != trace_.level_seeds[i - 1]) {
      level_seeds.push_back({i, trace_.level_seeds[i]});
    }
  }
  return {{"rows", row_count()},
          {"rewards", trace_.rewards},
          {"first", std::move(first)},
          {"level_seeds", std::move(level_seeds)},
          {"level_complete", std::move(level_complete)},
          {"actions", trace_.actions},
          {"total_reward", episode_returns_.back()},
          {"fingerprint", FingerprintJson(FingerprintAt(row_count() - 1))}};
}

Json Recording::FileFacts() const {
  const std::string game = absl::StrJoin(trace_.games, "-");
  const std::string mode(DistributionModeName(trace_.options.distribution_mode));
  const int32_t level_seed = trace_.level_seeds.front();
  return {{"game", game},
          {"mode", mode},
          {"level_seed", level_seed},
          {"steps", trace_.step_count},
          {"total_reward", episode_returns_.back()},
          {"fingerprint", FingerprintJson(FingerprintAt(row_count() - 1))},
          {"file_name", absl::StrCat(game, ".", mode, ".", level_seed, ".trace")}};
}

}  // namespace procgen::web
