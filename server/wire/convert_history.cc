#include "server/wire/convert_history.h"

#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

void FillRow(const PoolHistoryRow& row, v1::PoolHistoryRow* message) {
  FillTimestamp(row.time, message->mutable_time());
  message->set_step_count(row.step_count);
  message->set_episode_count(row.episode_count);
  const auto set = [message](void (v1::PoolHistoryRow::*setter)(float), float value) {
    if (!std::isnan(value)) {
      (message->*setter)(value);
    }
  };
  set(&v1::PoolHistoryRow::set_steps_per_second, row.steps_per_second);
  set(&v1::PoolHistoryRow::set_mean_episode_return, row.mean_episode_return);
  set(&v1::PoolHistoryRow::set_mean_episode_length, row.mean_episode_length);
  set(&v1::PoolHistoryRow::set_min_episode_return, row.min_episode_return);
  set(&v1::PoolHistoryRow::set_max_episode_return, row.max_episode_return);
  set(&v1::PoolHistoryRow::set_episode_return_deviation, row.episode_return_deviation);
  set(&v1::PoolHistoryRow::set_request_duration_p50_s, row.request_duration_p50_s);
  set(&v1::PoolHistoryRow::set_request_duration_p99_s, row.request_duration_p99_s);
  message->mutable_game_returns()->Add(row.game_returns.begin(), row.game_returns.end());
}

}  // namespace

absl::StatusOr<absl::Duration> HistorySpanOf(const v1::GetPoolHistoryRequest& request) {
  if (!request.has_span()) {
    return PoolHistory::kSpanDefault;
  }
  const absl::Duration span =
      absl::Seconds(request.span().seconds()) + absl::Nanoseconds(request.span().nanos());
  if (span <= absl::ZeroDuration() || span > PoolHistory::kSpanMax) {
    return absl::InvalidArgumentError(absl::StrCat("span is ", absl::FormatDuration(span),
                                                   ", allowed: above 0 to ",
                                                   absl::FormatDuration(PoolHistory::kSpanMax)));
  }
  return span;
}

void FillHistory(const PoolHistory::Series& series, v1::PoolHistory* message) {
  *message->mutable_interval() = DurationMessageOf(series.interval);
  for (const PoolHistoryRow& row : series.rows) {
    FillRow(row, message->add_rows());
  }
}

}  // namespace procgen
