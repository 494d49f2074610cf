#include "server/concurrency/start_thread.h"

#include <pthread.h>

#include <memory>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

// Larger than any address space, so a thread with this stack cannot start.
constexpr size_t kStackBytes = size_t{1} << 47;

TEST(StartThreadTest, RunsTheWork) {
  bool has_run = false;
  absl::StatusOr<std::thread> thread = StartThread([&] { has_run = true; });
  ASSERT_TRUE(thread.ok()) << thread.status();
  thread->join();
  EXPECT_TRUE(has_run);
}

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

TEST(StartThreadTest, FailedThreadStartIsAnErrorAndDestroysItsWork) {
  const NoThreads no_threads;
  auto held = std::make_shared<int>(0);
  const absl::StatusOr<std::thread> thread =
      StartThread([held] { ADD_FAILURE() << "it ran with a stack of 128 TiB"; });
  EXPECT_THAT(thread.status(),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("cannot start a thread")));
  EXPECT_EQ(held.use_count(), 1);
}

TEST(CheckThreadLimitTest, EnoughThreadsAreNoError) { EXPECT_THAT(CheckThreadLimit(4), IsOk()); }

TEST(CheckThreadLimitTest, TooFewThreadsAreAnError) {
  const NoThreads no_threads;
  EXPECT_THAT(CheckThreadLimit(4),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("cannot start a thread")));
}

}  // namespace
}  // namespace procgen
