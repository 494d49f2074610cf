#include "server/pool/history/pool_history.h"

#include <cmath>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::IsNan;
using testing::SizeIs;

constexpr int64_t kPlenty = int64_t{1} << 30;

PoolHistoryRow RowAt(int64_t second, int64_t step_count = 0) {
  PoolHistoryRow row;
  row.time = absl::FromUnixSeconds(second);
  row.step_count = step_count;
  return row;
}

TEST(PoolHistoryTest, RatesCoverTheIntervalBetweenSamples) {
  PoolHistory history;
  history.Add(RowAt(100, 50), kPlenty);
  history.Add(RowAt(102, 250), kPlenty);
  const PoolHistory::Series series = history.Read(PoolHistory::kSpanDefault);
  EXPECT_EQ(series.interval, absl::Seconds(1));
  ASSERT_THAT(series.rows, SizeIs(2));
  EXPECT_THAT(series.rows[0].steps_per_second, IsNan());  // no rate before the second sample
  EXPECT_EQ(series.rows[1].time, absl::FromUnixSeconds(102));
  EXPECT_EQ(series.rows[1].step_count, 250);
  EXPECT_EQ(series.rows[1].steps_per_second, 100);
  EXPECT_THAT(series.rows[1].mean_episode_return, IsNan());
}

TEST(PoolHistoryTest, RatesOfBurstsAreMeansOfTenSeconds) {
  PoolHistory history;
  for (int64_t second = 0; second <= 20; ++second) {
    history.Add(RowAt(second, second / 5 * 500), kPlenty);  // a burst every five seconds
  }
  const PoolHistory::Series series = history.Read(absl::Minutes(10));
  EXPECT_EQ(series.rows[12].steps_per_second, 100);
  EXPECT_EQ(series.rows.back().steps_per_second, 100);
}

TEST(PoolHistoryTest, LongSpansHaveCoarserRowsUpToTheNewest) {
  PoolHistory history;
  constexpr int kSeconds = 100'000;
  for (int second = 0; second <= kSeconds; ++second) {
    history.Add(RowAt(second, 3 * second), kPlenty);
  }
  const std::vector<std::pair<int32_t, int32_t>> spans = {{600, 1}, {3600, 10}, {86400, 240}};
  for (const auto& [span_s, interval_s] : spans) {
    const PoolHistory::Series series = history.Read(absl::Seconds(span_s));
    EXPECT_EQ(series.interval, absl::Seconds(interval_s));
    const std::vector<PoolHistoryRow>& rows = series.rows;
    EXPECT_LT(rows.size(), 700U);
    EXPECT_EQ(absl::ToUnixSeconds(rows.back().time), kSeconds);
    EXPECT_NEAR(static_cast<double>(absl::ToUnixSeconds(rows[0].time)), kSeconds - span_s,
                interval_s + 1)
        << span_s;
    for (size_t i = 1; i < rows.size(); ++i) {
      EXPECT_LT(rows[i - 1].time, rows[i].time) << span_s;
      EXPECT_EQ(rows[i].steps_per_second, 3.0F) << span_s;
    }
  }
}

TEST(PoolHistoryTest, CoarseRowsKeepExtremesAndAverageTheRest) {
  PoolHistory history;
  for (int second = 0; second <= 10; ++second) {
    PoolHistoryRow row = RowAt(second, second);
    row.episode_count = second;
    if (second > 0) {  // no episode in the first second
      row.mean_episode_return = static_cast<float>(second);
      row.min_episode_return = static_cast<float>(-second);
      row.max_episode_return = static_cast<float>(second % 5);
    }
    row.game_returns = {static_cast<float>(second), 2};
    history.Add(std::move(row), kPlenty);
  }
  const PoolHistory::Series series = history.Read(absl::Hours(1));
  ASSERT_THAT(series.rows, SizeIs(2));  // seconds 0 to 9, and 10
  const PoolHistoryRow& row = series.rows[0];
  EXPECT_EQ(row.time, absl::FromUnixSeconds(9));
  EXPECT_EQ(row.episode_count, 9);
  EXPECT_EQ(row.mean_episode_return, 5);  // of 1 to 9
  EXPECT_EQ(row.min_episode_return, -9);
  EXPECT_EQ(row.max_episode_return, 4);
  EXPECT_THAT(row.game_returns, ElementsAre(4.5F, 2));
}

TEST(PoolHistoryTest, LessMemoryKeepsFewerRowsOfEachResolution) {
  PoolHistory history;
  const int64_t tenth = PoolHistory::BytesMax(1) / 10;
  for (int second = 0; second <= 5000; ++second) {
    history.Add(RowAt(second), tenth);
  }
  EXPECT_THAT(history.Read(absl::Minutes(10)).rows, SizeIs(60));
  EXPECT_THAT(history.Read(absl::Hours(1)).rows, SizeIs(36 + 1));  // and the newest second
  for (int second = 5001; second <= 5010; ++second) {
    history.Add(RowAt(second), 1);
  }
  EXPECT_THAT(history.Read(absl::Minutes(10)).rows, SizeIs(1));
}

}  // namespace
}  // namespace procgen
