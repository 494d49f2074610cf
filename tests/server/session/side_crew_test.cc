#include "server/session/side_crew.h"

#include <atomic>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(SideCrewTest, AllWorkIsDoneBeforeItEnds) {
  std::atomic<int> count = 0;
  {
    SideCrew crew(2);
    for (int i = 0; i < 100; ++i) {
      crew.Run([&] { ++count; });
    }
  }
  EXPECT_EQ(count, 100);
}

TEST(SideCrewTest, WorkBeginsInOrder) {
  std::vector<int> order;
  {
    SideCrew crew(1);
    for (int i = 0; i < 4; ++i) {
      crew.Run([&order, i] { order.push_back(i); });
    }
  }
  EXPECT_THAT(order, testing::ElementsAre(0, 1, 2, 3));
}

TEST(SideCrewTest, WorkMayHandOverMore) {
  absl::Notification done;
  SideCrew crew(1);
  crew.Run([&] { crew.Run([&] { done.Notify(); }); });
  done.WaitForNotification();
}

}  // namespace
}  // namespace procgen
