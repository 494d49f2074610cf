#include "server/concurrency/thread_limit.h"

#include <pthread.h>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

// Larger than any address space, so a thread with this stack cannot start.
constexpr size_t kStackBytes = size_t{1} << 47;

// No thread can start during the object's life.
class NoThreads {
 public:
  NoThreads() {
    pthread_attr_t impossible;
    EXPECT_EQ(pthread_getattr_default_np(&usual_), 0);
    EXPECT_EQ(pthread_getattr_default_np(&impossible), 0);
    EXPECT_EQ(pthread_attr_setstacksize(&impossible, kStackBytes), 0);
    EXPECT_EQ(pthread_setattr_default_np(&impossible), 0);
  }
  ~NoThreads() { EXPECT_EQ(pthread_setattr_default_np(&usual_), 0); }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;

 private:
  pthread_attr_t usual_;
};

TEST(CheckThreadLimitTest, EnoughThreadsAreNoError) { EXPECT_THAT(CheckThreadLimit(4), IsOk()); }

TEST(CheckThreadLimitTest, TooFewThreadsAreAnError) {
  const NoThreads no_threads;
  EXPECT_THAT(CheckThreadLimit(4),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("cannot start a thread")));
}

}  // namespace
}  // namespace procgen
