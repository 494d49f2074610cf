#include "server/shared_memory/batch_ledger.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;

BatchLedger LedgerOf(int32_t batch_count) {
  BatchLedger ledger;
  ledger.Grow(batch_count);
  return ledger;
}

TEST(BatchLedgerTest, WhatIsHeldIsNotTakenUntilItIsReleased) {
  BatchLedger ledger = LedgerOf(2);
  EXPECT_THAT(ledger.Take({}, 1, false), IsOkAndHolds(0));
  EXPECT_THAT(ledger.Take({}, 2, false), IsOkAndHolds(1));
  EXPECT_THAT(ledger.Take({}, 3, false),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 2 of the 2")));
  EXPECT_THAT(ledger.Take({.released = {1}}, 3, false), IsOkAndHolds(1));
}

TEST(BatchLedgerTest, WhatIsKeptIsNotTakenUntilItIsForgotten) {
  BatchLedger ledger = LedgerOf(2);
  EXPECT_THAT(ledger.Take({}, 1, true), IsOkAndHolds(0));
  EXPECT_THAT(ledger.Take({.released = {0}}, 2, true), IsOkAndHolds(1));
  EXPECT_THAT(
      ledger.Take({.released = {1}}, 3, true),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 0 of the 2 batches")));
  EXPECT_THAT(ledger.Take({.released = {1}, .forgotten = 1}, 3, true), IsOkAndHolds(0));
}

TEST(BatchLedgerTest, WhatIsNotHeldCannotBeReleasedAndNothingChanges) {
  BatchLedger ledger = LedgerOf(3);
  ASSERT_THAT(ledger.Take({}, 1, false), IsOkAndHolds(0));
  ASSERT_THAT(ledger.Take({}, 2, false), IsOkAndHolds(1));
  for (const std::vector<int32_t>& released :
       {std::vector<int32_t>{2}, {0, 0}, {-1}, {3}, {INT32_MAX}, {INT32_MIN}}) {
    EXPECT_THAT(ledger.Apply({.released = released}),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("released_batches"), HasSubstr("it holds 2 of 3"))));
    EXPECT_EQ(ledger.HeldCount(), 2);
  }
}

TEST(BatchLedgerTest, RefusedRequestReleasesAndForgetsNothing) {
  BatchLedger ledger = LedgerOf(1);
  ASSERT_THAT(ledger.Take({}, 1, true), IsOkAndHolds(0));
  EXPECT_THAT(ledger.Take({.released = {0}}, 2, true),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("none for another")));
  EXPECT_EQ(ledger.HeldCount(), 1);
}

TEST(BatchLedgerTest, StreamThatBeginsHoldsWhatItSaysAndNothingElse) {
  BatchLedger ledger = LedgerOf(3);
  ASSERT_THAT(ledger.Take({}, 1, true), IsOkAndHolds(0));
  ASSERT_THAT(ledger.Take({}, 2, false), IsOkAndHolds(1));
  ASSERT_THAT(ledger.CheckHeld({1}), IsOk());
  ledger.BeginStream({1});
  EXPECT_EQ(ledger.HeldCount(), 1);
  EXPECT_THAT(ledger.Take({}, 3, false), IsOkAndHolds(2));  // 0 is kept for request 1
}

TEST(BatchLedgerTest, HeldBatchesThatThereAreNotAreRefused) {
  const BatchLedger ledger = LedgerOf(2);
  for (const std::vector<int32_t>& held : {std::vector<int32_t>{2}, {0, 0}, {-1}}) {
    EXPECT_THAT(ledger.CheckHeld(held),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("held_batches")));
  }
}

TEST(BatchLedgerTest, RepeatedAnswerIsHeldAgainAndStillKept) {
  BatchLedger ledger = LedgerOf(1);
  ASSERT_THAT(ledger.Take({}, 5, true), IsOkAndHolds(0));
  ledger.BeginStream({});
  EXPECT_EQ(ledger.HeldCount(), 0);
  ledger.HoldAgain(5);
  EXPECT_EQ(ledger.HeldCount(), 1);
  ledger.ForgetUpTo(5);
  EXPECT_THAT(ledger.Take({.released = {0}}, 6, true), IsOkAndHolds(0));
}

TEST(BatchLedgerTest, GrowingKeepsWhatIsHeld) {
  BatchLedger ledger = LedgerOf(1);
  ASSERT_THAT(ledger.Take({}, 1, false), IsOkAndHolds(0));
  ledger.Grow(2);
  ledger.Grow(1);
  EXPECT_EQ(ledger.batch_count(), 2);
  EXPECT_THAT(ledger.Take({}, 2, false), IsOkAndHolds(1));
}

}  // namespace
}  // namespace procgen
