#include "server/pool/turn_queue.h"

#include <deque>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;

TEST(TurnQueueTest, TurnsRunInOrderOneAtATime) {
  TurnQueue turns("pools/7");
  std::vector<int> order;
  for (const int number : {1, 2, 3}) {
    turns.Take([&order, number](const absl::Status& turn) {
      EXPECT_THAT(turn, IsOk());
      order.push_back(number);
    });
  }
  EXPECT_THAT(order, ElementsAre(1));
  turns.End();
  EXPECT_THAT(order, ElementsAre(1, 2));
  turns.End();
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
  turns.End();
}

TEST(TurnQueueTest, CallersBeyondTheLimitAreRejected) {
  TurnQueue turns("pools/7");
  int begun = 0;
  const auto count = [&](const absl::Status& status) { begun += status.ok() ? 1 : 0; };
  for (size_t i = 0; i < kTurnsWaitingMax + 1; ++i) {
    turns.Take(count);
  }
  absl::Status rejected;
  turns.Take([&](const absl::Status& status) { rejected = status; });
  EXPECT_THAT(rejected, StatusIs(absl::StatusCode::kResourceExhausted,
                                 "64 calls wait for pool pools/7, allowed: 64"));
  EXPECT_EQ(begun, 1);
}

TEST(TurnQueueTest, ClosedQueueReturnsWaitersAndGivesNoTurns) {
  TurnQueue turns("pools/7");
  turns.Take([](const absl::Status&) {});
  absl::Status waiting;
  turns.Take([&](const absl::Status& status) { waiting = status; });
  const absl::Status reason = absl::AbortedError("deleted");
  std::deque<TurnQueue::Begin> left = turns.Close(reason);
  ASSERT_EQ(left.size(), 1);
  left.front()(reason);
  EXPECT_THAT(waiting, StatusIs(absl::StatusCode::kAborted, "deleted"));
  turns.Take([&](const absl::Status& status) {
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kAborted, "deleted"));
  });
  turns.End();
}

}  // namespace
}  // namespace procgen
