#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/cluster/cluster.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(AloneTest, SoleNodeListsItself) {
  const auto alone = Cluster::Alone("a");
  EXPECT_EQ(alone->name(), "");
  EXPECT_THAT(alone->Nodes(), IsEmpty());
  NodeStatus status;
  status.pool_count = 3;
  alone->Publish(status);
  status.node_id = "a";
  EXPECT_THAT(alone->Nodes(), ElementsAre(status));
}

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
