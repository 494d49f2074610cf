#include "server/pool/history/pool_history.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace procgen {
namespace {

// Rows over which a rate is measured: learners that update their policy between rollouts step in
// bursts.
constexpr size_t kRateRows = 10;

// How the values of an interval become one.
enum class Combination : uint8_t { kMean, kMin, kMax };

constexpr std::pair<float PoolHistoryRow::*, Combination> kValues[] = {
    {&PoolHistoryRow::steps_per_second, Combination::kMean},
    {&PoolHistoryRow::mean_episode_return, Combination::kMean},
    {&PoolHistoryRow::mean_episode_length, Combination::kMean},
    {&PoolHistoryRow::min_episode_return, Combination::kMin},
    {&PoolHistoryRow::max_episode_return, Combination::kMax},
    {&PoolHistoryRow::episode_return_deviation, Combination::kMean},
    {&PoolHistoryRow::request_duration_p50_s, Combination::kMean},
    {&PoolHistoryRow::request_duration_p99_s, Combination::kMean}};

// Combines the values of an interval, without those that are NaN. NaN without values.
class Combiner {
 public:
  explicit Combiner(Combination combination) : combination_(combination) {}

  void Add(float value) {
    if (std::isnan(value)) {
      return;
    }
    sum_ += static_cast<double>(value);
    min_ = count_ == 0 ? value : std::min(min_, value);
    max_ = count_ == 0 ? value : std::max(max_, value);
    ++count_;
  }
  float Result() const {
    if (count_ == 0) {
      return PoolHistoryRow::kNone;
    }
    switch (combination_) {
      case Combination::kMin:
        return min_;
      case Combination::kMax:
        return max_;
      case Combination::kMean:
        break;
    }
    return static_cast<float>(sum_ / count_);
  }

 private:
  const Combination combination_;
  double sum_ = 0;
  float min_ = 0;
  float max_ = 0;
  int32_t count_ = 0;
};

PoolHistoryRow Combine(const std::vector<PoolHistoryRow>& rows) {
  PoolHistoryRow combined = rows.back();
  for (const auto& [value, combination] : kValues) {
    Combiner combiner(combination);
    for (const PoolHistoryRow& row : rows) {
      combiner.Add(row.*value);
    }
    combined.*value = combiner.Result();
  }
  for (size_t game = 0; game < combined.game_returns.size(); ++game) {
    Combiner combiner(Combination::kMean);
    for (const PoolHistoryRow& row : rows) {
      combiner.Add(row.game_returns[game]);
    }
    combined.game_returns[game] = combiner.Result();
  }
  return combined;
}

int64_t IntervalOf(const PoolHistoryRow& row, int32_t interval_s) {
  return absl::ToUnixSeconds(row.time) / interval_s;
}

// The finest resolution that covers a span.
size_t ResolutionFor(absl::Duration span) {
  size_t resolution = 0;
  while (resolution + 1 < PoolHistory::kResolutions.size() &&
         span > absl::Seconds(PoolHistory::kResolutions[resolution].interval_s) *
                    PoolHistory::kResolutions[resolution].rows_max) {
    ++resolution;
  }
  return resolution;
}

}  // namespace

int64_t PoolHistory::BytesMax(size_t game_count) {
  size_t rows = 0;
  for (const Resolution& resolution : kResolutions) {
    rows += resolution.rows_max;
  }
  const size_t games = game_count > 1 ? game_count : 0;
  return static_cast<int64_t>(rows * (sizeof(PoolHistoryRow) + games * sizeof(float)));
}

void PoolHistory::Add(PoolHistoryRow row, int64_t bytes_max) {
  absl::MutexLock lock(&mutex_);
  if (const std::deque<PoolHistoryRow>& rows = rows_[0].complete; !rows.empty()) {
    const PoolHistoryRow& first = rows[rows.size() - std::min(rows.size(), kRateRows)];
    const double seconds = absl::ToDoubleSeconds(row.time - first.time);
    row.steps_per_second =
        seconds > 0
            ? static_cast<float>(static_cast<double>(row.step_count - first.step_count) / seconds)
            : rows.back().steps_per_second;
  }
  const double share = std::min(
      1.0, static_cast<double>(bytes_max) /
               static_cast<double>(BytesMax(std::max<size_t>(1, row.game_returns.size()))));
  AddRow(std::move(row), 0, share);
}

// NOLINTNEXTLINE(misc-no-recursion): as deep as there are resolutions
void PoolHistory::AddRow(PoolHistoryRow row, size_t resolution, double share) {
  if (const size_t coarser = resolution + 1; coarser < kResolutions.size()) {
    std::vector<PoolHistoryRow>& pending = rows_[coarser].pending;
    const int32_t interval_s = kResolutions[coarser].interval_s;
    if (!pending.empty() &&
        IntervalOf(pending.front(), interval_s) != IntervalOf(row, interval_s)) {
      AddRow(Combine(pending), coarser, share);
      pending.clear();
    }
    pending.push_back(row);
  }
  std::deque<PoolHistoryRow>& rows = rows_[resolution].complete;
  rows.push_back(std::move(row));
  const auto rows_max = static_cast<size_t>(
      std::max(1.0, share * static_cast<double>(kResolutions[resolution].rows_max)));
  while (rows.size() > rows_max) {
    rows.pop_front();
  }
}

PoolHistory::Series PoolHistory::Read(absl::Duration span) const {
  const size_t resolution = ResolutionFor(span);
  Series series = {.interval = absl::Seconds(kResolutions[resolution].interval_s), .rows = {}};
  absl::MutexLock lock(&mutex_);
  if (rows_[0].complete.empty()) {
    return series;
  }
  const absl::Time begin = rows_[0].complete.back().time - span;
  const auto select = [begin, &series](const auto& rows) {
    for (const PoolHistoryRow& row : rows) {
      if (row.time > begin) {
        series.rows.push_back(row);
      }
    }
  };
  select(rows_[resolution].complete);
  for (size_t finer = resolution; finer > 0; --finer) {
    select(rows_[finer].pending);
  }
  return series;
}

}  // namespace procgen
