#include "server/pool/request_pause.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

class RequestPauseTest : public testing::Test {
 protected:
  // Passes the next request and returns whether it began at once.
  bool Pass() {
    const int before = begun_;
    pause_.Pass([this] { ++begun_; });
    return begun_ > before;
  }

  RequestPause pause_;
  int begun_ = 0;
};

TEST_F(RequestPauseTest, RequestsWaitUntilEachPauseHasEnded) {
  EXPECT_TRUE(Pass());
  pause_.Pause();
  pause_.Pause();
  EXPECT_TRUE(pause_.paused());
  EXPECT_FALSE(Pass());
  pause_.EndPause();
  EXPECT_TRUE(pause_.paused());
  EXPECT_EQ(begun_, 1);
  pause_.EndPause();
  EXPECT_FALSE(pause_.paused());
  EXPECT_EQ(begun_, 2);
  EXPECT_TRUE(Pass());
}

TEST_F(RequestPauseTest, PassOneLetsTheWaitingRequestPassOrElseTheNext) {
  pause_.PassOne();  // not paused: no effect
  pause_.Pause();
  EXPECT_FALSE(Pass());
  pause_.PassOne();
  EXPECT_EQ(begun_, 1);
  pause_.PassOne();
  pause_.PassOne();
  EXPECT_TRUE(Pass());
  EXPECT_TRUE(Pass());
  EXPECT_FALSE(Pass());
}

TEST_F(RequestPauseTest, UnusedPassesEndWithThePause) {
  pause_.Pause();
  pause_.PassOne();
  pause_.EndPause();
  pause_.Pause();
  EXPECT_FALSE(Pass());
}

TEST_F(RequestPauseTest, StreamThatEndsDoesNotWait) {
  pause_.Pause();
  EXPECT_FALSE(Pass());
  pause_.PassStream();
  EXPECT_EQ(begun_, 1);
  EXPECT_TRUE(Pass());
}

}  // namespace
}  // namespace procgen
