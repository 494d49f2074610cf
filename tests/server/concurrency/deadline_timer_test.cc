#include "server/concurrency/deadline_timer.h"

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "tests/server/session/test_pool_context.h"

namespace procgen {
namespace {

TEST(DeadlineTimerTest, FiresAtItsDeadline) {
  TestClock clock;
  absl::Notification fired;
  absl::Time time;
  DeadlineTimer timer([&] { return clock.Now(); },
                      [&](absl::Time now) {
                        time = now;
                        fired.Notify();
                        return absl::InfiniteFuture();
                      });
  timer.ArmBy(clock.Now());
  fired.WaitForNotification();
  EXPECT_EQ(time, clock.Now());
}

TEST(DeadlineTimerTest, CallbackCanRearm) {
  absl::Notification fired_twice;
  int count = 0;
  DeadlineTimer timer(SteadyNow, [&](absl::Time now) {
    if (++count == 2) {
      fired_twice.Notify();
    }
    return count < 2 ? now : absl::InfiniteFuture();
  });
  timer.ArmBy(absl::InfinitePast());
  fired_twice.WaitForNotification();
}

TEST(DeadlineTimerTest, EarlierDeadlineReplacesALaterOne) {
  TestClock clock;
  absl::Notification fired;
  DeadlineTimer timer([&] { return clock.Now(); },
                      [&](absl::Time) {
                        fired.Notify();
                        return absl::InfiniteFuture();
                      });
  timer.ArmBy(clock.Now() + absl::Hours(1));
  timer.ArmBy(clock.Now());
  timer.ArmBy(clock.Now() + absl::Hours(2));
  fired.WaitForNotification();
}

TEST(DeadlineTimerTest, EndsWithoutFiring) {
  DeadlineTimer timer(SteadyNow, [](absl::Time) {
    ADD_FAILURE() << "it fired";
    return absl::InfiniteFuture();
  });
  timer.ArmBy(SteadyNow() + absl::Hours(1));
}

}  // namespace
}  // namespace procgen
