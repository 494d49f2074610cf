#include "server/web/session/pool_history.h"

#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace procgen::web {
namespace {

v1::Pool PoolOf(const std::string& owner, int64_t create_time, int64_t step_count) {
  v1::Pool pool;
  pool.set_name("pools/a");
  pool.set_owner(owner);
  pool.mutable_create_time()->set_seconds(create_time);
  pool.set_step_count(step_count);
  return pool;
}

PoolReport ReportOf(const std::string& owner, int64_t create_time, int64_t step_count) {
  PoolReport report;
  report.pool = PoolOf(owner, create_time, step_count);
  return report;
}

// The rows of the pool "a" without an owner, created at 1.
Json RowsOf(const PoolHistory& history, int32_t span_s) {
  return history.RowsOf(PoolOf("", 1, 0), span_s)["rows"];
}

// The place of a value in a row.
size_t ColumnOf(const PoolHistory& history, const std::string& name) {
  const Json columns = history.RowsOf(PoolOf("", 1, 0), 600)["columns"];
  for (size_t column = 0; column < columns.size(); ++column) {
    if (columns[column] == name) {
      return column;
    }
  }
  ADD_FAILURE() << "no column " << name;
  return 0;
}

TEST(PoolHistoryTest, RatesCoverTheIntervalBetweenSamples) {
  PoolHistory history;
  history.Add(100, {ReportOf("", 1, 50)});
  EXPECT_TRUE(history.NewestOf(PoolOf("", 1, 0))["steps_per_second"].is_null());
  history.Add(102, {ReportOf("", 1, 250)});
  EXPECT_EQ(history.NewestOf(PoolOf("", 1, 0))["steps_per_second"], 100);
  const Json rows = RowsOf(history, 600);
  const size_t rate = ColumnOf(history, "steps_per_second");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_TRUE(rows[0][rate].is_null());  // no rate before the second sample
  EXPECT_EQ(rows[1][0], 102.0);
  EXPECT_EQ(rows[1][1], 250.0);
  EXPECT_EQ(rows[1][rate], 100.0);
  EXPECT_TRUE(rows[1][ColumnOf(history, "mean_return")].is_null());  // no episode has ended
}

TEST(PoolHistoryTest, RatesOfBurstsAreMeansOfTenSeconds) {
  PoolHistory history;
  for (int32_t second = 0; second <= 20; ++second) {
    history.Add(second, {ReportOf("", 1, second / 5 * 500)});  // a burst every five seconds
  }
  EXPECT_EQ(history.NewestOf(PoolOf("", 1, 0))["steps_per_second"], 100);
  const Json rows = RowsOf(history, 600);
  EXPECT_EQ(rows[12][ColumnOf(history, "steps_per_second")], 100.0);
}

TEST(PoolHistoryTest, LastStepIsTheLastSampleWithSteps) {
  PoolHistory history;
  history.Add(100, {ReportOf("", 1, 0)});
  EXPECT_TRUE(history.NewestOf(PoolOf("", 1, 0))["last_step_time_s"].is_null());
  history.Add(101, {ReportOf("", 1, 8)});
  history.Add(102, {ReportOf("", 1, 8)});
  EXPECT_EQ(history.NewestOf(PoolOf("", 1, 0))["last_step_time_s"], 101.0);
}

TEST(PoolHistoryTest, PoolsWithTheSameNameAreDistinguished) {
  PoolHistory history;
  history.Add(1, {ReportOf("alice", 1, 0), ReportOf("bob", 1, 0)});
  history.Add(2, {ReportOf("alice", 1, 7), ReportOf("bob", 1, 9)});
  EXPECT_EQ(history.NewestOf(PoolOf("alice", 1, 0))["steps_per_second"], 7);
  EXPECT_EQ(history.NewestOf(PoolOf("bob", 1, 0))["steps_per_second"], 9);
  // Deleted and created again with the same name.
  history.Add(3, {ReportOf("alice", 2, 1), ReportOf("bob", 1, 9)});
  EXPECT_EQ(history.RowsOf(PoolOf("alice", 2, 0), 600)["rows"].size(), 1U);
  EXPECT_EQ(history.RowsOf(PoolOf("alice", 1, 0), 600)["rows"].size(), 0U);
  EXPECT_EQ(history.RowsOf(PoolOf("bob", 1, 0), 600)["rows"].size(), 3U);
}

TEST(PoolHistoryTest, LongSpansHaveCoarserRowsUpToTheNewest) {
  PoolHistory history;
  constexpr int kSeconds = 100'000;
  for (int second = 0; second <= kSeconds; ++second) {
    history.Add(second, {ReportOf("", 1, 3 * second)});
  }
  const std::vector<std::pair<int32_t, int32_t>> spans = {{600, 1}, {3600, 10}, {86400, 240}};
  for (const auto& [span_s, interval_s] : spans) {
    const Json answer = history.RowsOf(PoolOf("", 1, 0), span_s);
    EXPECT_EQ(answer["interval_s"], interval_s);
    const Json& rows = answer["rows"];
    EXPECT_LT(rows.size(), 700U);
    EXPECT_EQ(rows.back()[0], kSeconds);
    EXPECT_NEAR(rows[0][0].get<double>(), kSeconds - span_s, interval_s + 1) << span_s;
    for (size_t i = 1; i < rows.size(); ++i) {
      EXPECT_LT(rows[i - 1][0], rows[i][0]) << span_s;
      EXPECT_EQ(rows[i][2], 3.0) << "steps per second, span " << span_s;
    }
  }
  history.Add(kSeconds + 1, {});
  EXPECT_EQ(RowsOf(history, 600).size(), 0U);
}

TEST(PoolHistoryTest, CoarseRowsKeepExtremesAndAverageTheRest) {
  PoolHistory history;
  for (int second = 0; second <= 10; ++second) {
    PoolReport report = ReportOf("", 1, second);
    report.pool.set_episode_count(second);  // none in the first second
    report.pool.set_mean_episode_return(static_cast<float>(second));
    report.return_min = static_cast<float>(-second);
    report.return_max = static_cast<float>(second % 5);
    report.game_returns = {{"heist", static_cast<float>(second)}, {"maze", 2}};
    history.Add(second, {report});
  }
  const Json answer = history.RowsOf(PoolOf("", 1, 0), 3600);
  ASSERT_EQ(answer["rows"].size(), 2U);  // seconds 0 to 9, and 10
  const Json& row = answer["rows"][0];
  EXPECT_EQ(row[0], 9.0);
  EXPECT_EQ(row[ColumnOf(history, "episode_count")], 9.0);
  EXPECT_EQ(row[ColumnOf(history, "mean_return")], 5.0);  // of 1 to 9
  EXPECT_EQ(row[ColumnOf(history, "return_min")], -9.0);
  EXPECT_EQ(row[ColumnOf(history, "return_max")], 4.0);
  EXPECT_EQ(answer["games"], Json({"heist", "maze"}));
  EXPECT_EQ(row[answer["columns"].size()], 4.5);
  EXPECT_EQ(row[answer["columns"].size() + 1], 2.0);
  EXPECT_EQ(history.NewestOf(PoolOf("", 1, 0))["game_returns"]["heist"], 10.0);
}

TEST(PoolHistoryTest, ReturnsAreEvenlySpacedUpToTheNewest) {
  PoolHistory history;
  for (int second = 1; second <= 100; ++second) {
    PoolReport report = ReportOf("", 1, second);
    report.pool.set_episode_count(1);
    report.pool.set_mean_episode_return(static_cast<float>(second));
    history.Add(second, {report});
  }
  const Json returns = history.ReturnsOf(PoolOf("", 1, 0), 5);
  ASSERT_EQ(returns.size(), 5U);
  EXPECT_EQ(returns.back(), 100.0);
  EXPECT_LT(returns.front(), 30.0);
  EXPECT_EQ(history.ReturnsOf(PoolOf("", 2, 0), 5).size(), 0U);
}

}  // namespace
}  // namespace procgen::web
