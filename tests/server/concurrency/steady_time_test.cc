// tests/wall_clock moves the wall clock of this process.

#include "server/concurrency/steady_time.h"

#include <chrono>
#include <thread>

#include "gtest/gtest.h"
#include "tests/wall_clock/wall_clock.h"

namespace procgen {
namespace {

constexpr absl::Duration kShort = absl::Milliseconds(50);
constexpr absl::Duration kLong = absl::Hours(2);

class SteadyTimeTest : public testing::TestWithParam<absl::Duration> {
 protected:
  ~SteadyTimeTest() override { SetWallClockOffset(0); }

  // Moves the clock once the other thread waits.
  static void Jump() { SetWallClockOffset(absl::ToInt64Nanoseconds(GetParam())); }
};

TEST_P(SteadyTimeTest, WallClockCanBeMovedByTheTest) {
  using WallClock = std::chrono::system_clock;  // absl::Now follows it within seconds only
  const WallClock::time_point before = WallClock::now();
  Jump();
  const absl::Duration moved = absl::FromChrono(WallClock::now() - before);
  EXPECT_NEAR(absl::ToDoubleMinutes(moved), absl::ToDoubleMinutes(GetParam()), 1);
}

TEST_P(SteadyTimeTest, SteadyTimeIgnoresClockChanges) {
  const absl::Time before = SteadyNow();
  Jump();
  const absl::Duration passed = SteadyNow() - before;
  EXPECT_GE(passed, absl::ZeroDuration());
  EXPECT_LT(passed, absl::Minutes(1));
}

TEST_P(SteadyTimeTest, WaitEndsAtItsDeadlineDespiteAClockChange) {
  absl::Mutex mutex;
  SteadyCondVar changed;
  const absl::Time begin = SteadyNow();
  std::thread jump([this] { Jump(); });
  {
    absl::MutexLock lock(&mutex);
    EXPECT_FALSE(changed.AwaitUntil(&mutex, begin + kShort, [] { return false; }));
  }
  EXPECT_GE(SteadyNow() - begin, kShort);
  EXPECT_LT(SteadyNow() - begin, absl::Minutes(1));
  jump.join();
}

TEST_P(SteadyTimeTest, WaitEndsOnNotifyDespiteAClockChange) {
  absl::Mutex mutex;
  SteadyCondVar changed;
  bool is_due = false;
  std::thread change([&] {
    Jump();
    absl::MutexLock lock(&mutex);
    is_due = true;
    changed.NotifyAll();
  });
  absl::MutexLock lock(&mutex);
  EXPECT_TRUE(changed.AwaitUntil(&mutex, SteadyNow() + kLong, [&] { return is_due; }));
  change.join();
}

TEST_P(SteadyTimeTest, ANotificationIsAwaitedUntilItsTimeout) {
  SteadyNotification notification;
  Jump();
  EXPECT_FALSE(notification.WaitWithTimeout(kShort));
  notification.Notify();
  EXPECT_TRUE(notification.WaitWithTimeout(kLong));
  EXPECT_TRUE(notification.HasBeenNotified());
}

TEST_P(SteadyTimeTest, ADeadlineMayBeInTheInfiniteFuture) {
  SteadyNotification notification;
  std::thread notify([&] { notification.Notify(); });
  EXPECT_TRUE(notification.WaitWithTimeout(absl::InfiniteDuration()));
  notify.join();
}

INSTANTIATE_TEST_SUITE_P(Jumps, SteadyTimeTest, testing::Values(-absl::Hours(1), absl::Hours(1)),
                         [](const auto& info) {
                           return info.param < absl::ZeroDuration() ? "Back" : "Forth";
                         });

}  // namespace
}  // namespace procgen
