#include "server/shared_memory/slot_table.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SlotTable TableOf(int32_t batch_count) {
  SlotTable table;
  table.Grow(batch_count);
  return table;
}

TEST(SlotTableTest, HeldSlotsAreNotReusedUntilReleased) {
  SlotTable table = TableOf(2);
  EXPECT_THAT(table.Take({}, 1, false), IsOkAndHolds(0));
  EXPECT_THAT(table.Take({}, 2, false), IsOkAndHolds(1));
  EXPECT_THAT(table.Take({}, 3, false),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 2 of the 2")));
  EXPECT_THAT(table.Take({.released = {1}}, 3, false), IsOkAndHolds(1));
}

TEST(SlotTableTest, KeptSlotsAreNotReusedUntilDropped) {
  SlotTable table = TableOf(2);
  EXPECT_THAT(table.Take({}, 1, true), IsOkAndHolds(0));
  EXPECT_THAT(table.Take({.released = {0}}, 2, true), IsOkAndHolds(1));
  EXPECT_THAT(
      table.Take({.released = {1}}, 3, true),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 0 of the 2 batches")));
  EXPECT_THAT(table.Take({.released = {1}, .forgotten = 1}, 3, true), IsOkAndHolds(0));
}

TEST(SlotTableTest, ReleaseOfAFreeSlotIsRejectedAndChangesNothing) {
  SlotTable table = TableOf(3);
  ASSERT_THAT(table.Take({}, 1, false), IsOkAndHolds(0));
  ASSERT_THAT(table.Take({}, 2, false), IsOkAndHolds(1));
  for (const std::vector<int32_t>& released :
       {std::vector<int32_t>{2}, {0, 0}, {-1}, {3}, {INT32_MAX}, {INT32_MIN}}) {
    EXPECT_THAT(table.Apply({.released = released}),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("released_batches"), HasSubstr("it holds 2 of 3"))));
    EXPECT_EQ(table.HeldCount(), 2);
  }
}

TEST(SlotTableTest, RejectedRequestChangesNothing) {
  SlotTable table = TableOf(1);
  ASSERT_THAT(table.Take({}, 1, true), IsOkAndHolds(0));
  EXPECT_THAT(table.Take({.released = {0}}, 2, true),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("none for another")));
  EXPECT_EQ(table.HeldCount(), 1);
}

TEST(SlotTableTest, NewStreamHoldsExactlyItsHeldBatches) {
  SlotTable table = TableOf(3);
  ASSERT_THAT(table.Take({}, 1, true), IsOkAndHolds(0));
  ASSERT_THAT(table.Take({}, 2, false), IsOkAndHolds(1));
  ASSERT_THAT(table.CheckHeld({1}), IsOk());
  table.BeginStream({1});
  EXPECT_EQ(table.HeldCount(), 1);
  EXPECT_THAT(table.Take({}, 3, false), IsOkAndHolds(2));  // 0 is kept for request 1
}

TEST(SlotTableTest, UnknownHeldBatchesAreRejected) {
  const SlotTable table = TableOf(2);
  for (const std::vector<int32_t>& held : {std::vector<int32_t>{2}, {0, 0}, {-1}}) {
    EXPECT_THAT(table.CheckHeld(held),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("held_batches")));
  }
}

TEST(SlotTableTest, RepeatedResponseIsHeldAndKept) {
  SlotTable table = TableOf(1);
  ASSERT_THAT(table.Take({}, 5, true), IsOkAndHolds(0));
  table.BeginStream({});
  EXPECT_EQ(table.HeldCount(), 0);
  table.HoldAgain(5);
  EXPECT_EQ(table.HeldCount(), 1);
  table.ForgetUpTo(5);
  EXPECT_THAT(table.Take({.released = {0}}, 6, true), IsOkAndHolds(0));
}

TEST(SlotTableTest, GrowingKeepsHeldSlots) {
  SlotTable table = TableOf(1);
  ASSERT_THAT(table.Take({}, 1, false), IsOkAndHolds(0));
  table.Grow(2);
  table.Grow(1);
  EXPECT_EQ(table.batch_count(), 2);
  EXPECT_THAT(table.Take({}, 2, false), IsOkAndHolds(1));
}

}  // namespace
}  // namespace procgen
