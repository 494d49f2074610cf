#include "server/fleet/pool/shard_thread_budget.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(ShardThreadBudgetTest, ReservationsAreBoundedByTheFreeThreads) {
  ShardThreadBudget budget(3);
  const auto first = budget.Reserve(2);
  ASSERT_THAT(first, IsOk());
  EXPECT_EQ(first->size(), 2);
  const auto second = budget.Reserve(2);
  ASSERT_THAT(second, IsOk());
  EXPECT_EQ(second->size(), 1);
  EXPECT_EQ(budget.available(), 0);
  EXPECT_THAT(budget.Reserve(1), StatusIs(absl::StatusCode::kResourceExhausted,
                                          testing::HasSubstr("runs 3 shards, limit 3")));
}

TEST(ShardThreadBudgetTest, ReservationCountsUntilItIsDestroyed) {
  ShardThreadBudget budget(2);
  auto reserved = budget.Reserve(2);
  ASSERT_THAT(reserved, IsOk());
  reserved->pop_back();
  EXPECT_EQ(budget.available(), 1);
  reserved->clear();
  EXPECT_EQ(budget.available(), 2);
}

}  // namespace
}  // namespace procgen
