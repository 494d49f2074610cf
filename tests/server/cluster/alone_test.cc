#include "gtest/gtest.h"
#include "server/cluster/cluster.h"

namespace procgen {
namespace {

TEST(AloneTest, SubscribersAreNotifiedUntilTheSubscriptionEnds) {
  const auto alone = Cluster::Alone("a");
  int notification_count = 0;
  {
    const Subscription subscription = alone->Subscribe([&] { ++notification_count; });
    alone->Publish(NodeStatus());
    alone->Publish(NodeStatus());  // unchanged
    EXPECT_EQ(notification_count, 1);
    NodeStatus draining;
    draining.draining = true;
    alone->Publish(draining);
    EXPECT_EQ(notification_count, 2);
  }
  alone->Publish(NodeStatus());
  EXPECT_EQ(notification_count, 2);
}

}  // namespace
}  // namespace procgen
