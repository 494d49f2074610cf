#include "server/rpc/step/response_queue.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(ResponseQueueTest, DefaultCapacityIsTwoResponses) {
  ResponseQueue queue;
  Response* first = queue.Take();
  queue.Take();
  EXPECT_FALSE(queue.has_free());
  EXPECT_NE(queue.Take(), nullptr);
  queue.Release(first);
  EXPECT_EQ(queue.Take(), first) << "memory is reused";
}

TEST(ResponseQueueTest, ReturnedResponseReleasesItsObservations) {
  ResponseQueue queue;
  Response* response = queue.Take();
  bool released = false;
  response->observations = grpc::Slice(
      &released, 1, [](void* held) { *static_cast<bool*>(held) = true; }, &released);
  queue.Push({response, {}, nullptr});
  queue.BeginWrite();
  EXPECT_FALSE(released);
  queue.EndWrite();
  EXPECT_TRUE(released);
}

TEST(ResponseQueueTest, OneIsWrittenAtATimeAndInOrder) {
  ResponseQueue queue;
  StreamRequest request;
  Response* first = queue.Take();
  Response* second = queue.Take();
  queue.Push({first, {}, nullptr});
  queue.Push({second, {}, &request});
  queue.BeginWrite();
  EXPECT_FALSE(queue.CanWrite());
  EXPECT_EQ(queue.writing()->response, first);
  EXPECT_EQ(queue.EndWrite(), nullptr);
  EXPECT_TRUE(queue.has_free());
  queue.BeginWrite();
  EXPECT_EQ(queue.writing()->response, second);
  EXPECT_EQ(queue.EndWrite(), &request);
  EXPECT_TRUE(queue.empty());
}

TEST(ResponseQueueTest, DroppingLeavesWhatIsBeingWritten) {
  ResponseQueue queue;
  Response* first = queue.Take();
  queue.Push({first, {}, nullptr});
  queue.Push({queue.Take(), {}, nullptr});
  queue.Push({nullptr, Serialized(Response()), nullptr});
  queue.BeginWrite();
  queue.DropUnwritten();
  EXPECT_TRUE(queue.has_free());
  EXPECT_EQ(queue.writing()->response, first);
  queue.EndWrite();
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace procgen
