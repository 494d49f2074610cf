#include "server/rpc/step/request_window.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

// Reads a request into the inbox.
StreamRequest* Read(RequestWindow* window) {
  window->BeginRead();
  StreamRequest* request = window->EndRead(/*ok=*/true);
  window->Enqueue(request);
  return request;
}

TEST(RequestWindowTest, FullWindowReadsNothing) {
  RequestWindow window;
  window.Grow(2);
  StreamRequest* first = Read(&window);
  StreamRequest* second = Read(&window);
  EXPECT_FALSE(window.CanRead());
  EXPECT_EQ(window.Next(), first);
  EXPECT_FALSE(window.CanRead());
  window.Free(first);
  EXPECT_TRUE(window.CanRead());
  EXPECT_EQ(window.Next(), second);
  EXPECT_EQ(window.Next(), nullptr);
}

TEST(RequestWindowTest, OneIsReadAtATime) {
  RequestWindow window;
  window.Grow(3);
  window.BeginRead();
  EXPECT_FALSE(window.CanRead());
  StreamRequest* request = window.EndRead(/*ok=*/true);
  EXPECT_FALSE(window.CanRead()) << "a request is being parsed";
  window.Enqueue(request);
  EXPECT_TRUE(window.CanRead());
}

TEST(RequestWindowTest, EndsWhenAllReadRequestsAreExecuted) {
  RequestWindow window;
  window.Grow(2);
  Read(&window);
  window.BeginRead();
  EXPECT_EQ(window.EndRead(/*ok=*/false), nullptr);
  EXPECT_FALSE(window.CanRead());
  EXPECT_FALSE(window.IsOver());
  EXPECT_NE(window.Next(), nullptr);
  EXPECT_TRUE(window.IsOver());
}

TEST(RequestWindowTest, StoppingDropsQueuedRequests) {
  RequestWindow window;
  window.Grow(3);
  Read(&window);
  window.BeginRead();
  StreamRequest* parsed = window.EndRead(/*ok=*/true);
  window.Stop();
  EXPECT_FALSE(window.IsOver()) << "a request is being parsed";
  window.Enqueue(parsed);
  EXPECT_TRUE(window.IsOver());
  EXPECT_EQ(window.Next(), nullptr);
}

}  // namespace
}  // namespace procgen
