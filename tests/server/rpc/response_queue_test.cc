#include "server/rpc/response_queue.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(ResponseQueueTest, MessagesAreTwoUnlessMoreAreAskedFor) {
  ResponseQueue queue;
  v1::StepPoolResponse* first = queue.Take();
  queue.Take();
  EXPECT_FALSE(queue.has_free());
  EXPECT_NE(queue.Take(), nullptr);
  queue.GiveBack(first);
  EXPECT_EQ(queue.Take(), first) << "memory is used again";
}

TEST(ResponseQueueTest, OneIsWrittenAtATimeAndInOrder) {
  ResponseQueue queue;
  StreamRequest request;
  v1::StepPoolResponse* first = queue.Take();
  v1::StepPoolResponse* second = queue.Take();
  queue.Push({first, {}, nullptr});
  queue.Push({second, {}, &request});
  queue.BeginWrite();
  EXPECT_FALSE(queue.CanWrite());
  EXPECT_EQ(queue.writing()->message, first);
  EXPECT_EQ(queue.EndWrite(), nullptr);
  EXPECT_TRUE(queue.has_free());
  queue.BeginWrite();
  EXPECT_EQ(queue.writing()->message, second);
  EXPECT_EQ(queue.EndWrite(), &request);
  EXPECT_TRUE(queue.empty());
}

TEST(ResponseQueueTest, DroppingLeavesWhatIsBeingWritten) {
  ResponseQueue queue;
  v1::StepPoolResponse* first = queue.Take();
  queue.Push({first, {}, nullptr});
  queue.Push({queue.Take(), {}, nullptr});
  queue.Push({nullptr, Serialized(v1::StepPoolResponse()), nullptr});
  queue.BeginWrite();
  queue.DropUnwritten();
  EXPECT_TRUE(queue.has_free());
  EXPECT_EQ(queue.writing()->message, first);
  queue.EndWrite();
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace procgen
