#include "server/concurrency/deadline_timer.h"

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

// The time of a clock that stands still.
constexpr absl::Time kNow = absl::UnixEpoch();

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
  absl::Notification fired;
  DeadlineTimer timer([] { return kNow; },
                      [&](absl::Time) {
                        fired.Notify();
                        return absl::InfiniteFuture();
                      });
  timer.ArmBy(kNow + absl::Hours(1));
  timer.ArmBy(kNow);
  timer.ArmBy(kNow + absl::Hours(2));
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
