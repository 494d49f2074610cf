#include "server/web/session/pool_history.h"

#include <string>
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

TEST(PoolHistoryTest, RatesCoverTheIntervalBetweenSamples) {
  PoolHistory history;
  history.Add(100, {PoolOf("alice", 1, 50)});
  EXPECT_EQ(history.StepsPerSecond(PoolOf("alice", 1, 0)), 0);
  history.Add(102, {PoolOf("alice", 1, 250)});
  EXPECT_EQ(history.StepsPerSecond(PoolOf("alice", 1, 0)), 100);
  const Json rows = history.RowsOf(PoolOf("alice", 1, 0))["rows"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][0], 102.0);
  EXPECT_EQ(rows[1][1], 100.0);
  EXPECT_TRUE(rows[1][3].is_null());  // no episode has ended
}

TEST(PoolHistoryTest, PoolsWithTheSameNameAreDistinguished) {
  PoolHistory history;
  history.Add(1, {PoolOf("alice", 1, 0), PoolOf("bob", 1, 0)});
  history.Add(2, {PoolOf("alice", 1, 7), PoolOf("bob", 1, 9)});
  EXPECT_EQ(history.StepsPerSecond(PoolOf("alice", 1, 0)), 7);
  EXPECT_EQ(history.StepsPerSecond(PoolOf("bob", 1, 0)), 9);
  // Deleted and created again with the same name.
  history.Add(3, {PoolOf("alice", 2, 1), PoolOf("bob", 1, 9)});
  EXPECT_EQ(history.RowsOf(PoolOf("alice", 2, 0))["rows"].size(), 1U);
  EXPECT_EQ(history.RowsOf(PoolOf("alice", 1, 0))["rows"].size(), 0U);
  EXPECT_EQ(history.RowsOf(PoolOf("bob", 1, 0))["rows"].size(), 3U);
}

TEST(PoolHistoryTest, TenMinutesAreKept) {
  PoolHistory history;
  for (int second = 0; second < 700; ++second) {
    history.Add(second, {PoolOf("", 1, second)});
  }
  const Json rows = history.RowsOf(PoolOf("", 1, 0))["rows"];
  EXPECT_EQ(rows.size(), 600U);
  EXPECT_EQ(rows[0][0], 100.0);
  history.Add(700, {});
  EXPECT_EQ(history.RowsOf(PoolOf("", 1, 0))["rows"].size(), 0U);
}

}  // namespace
}  // namespace procgen::web
