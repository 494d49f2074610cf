#include "server/pool/quota/byte_budget.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(ByteBudgetTest, ExcessReservationIsRejectedAndChangesNothing) {
  ByteBudget budget(100);
  EXPECT_TRUE(budget.Change(0, 60));
  EXPECT_FALSE(budget.Change(0, 41));
  EXPECT_FALSE(budget.Change(60, 101));
  EXPECT_FALSE(budget.Change(0, INT64_MAX));
  EXPECT_EQ(budget.reserved_bytes(), 60);
  EXPECT_TRUE(budget.Change(0, 40));
}

TEST(ByteBudgetTest, ReturnedBytesAreFree) {
  ByteBudget budget(100);
  EXPECT_TRUE(budget.Change(0, 100));
  EXPECT_TRUE(budget.Change(100, 0));
  EXPECT_TRUE(budget.Change(0, 100));
}

}  // namespace
}  // namespace procgen
