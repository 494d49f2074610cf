#include "server/concurrency/alarm.h"

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "tests/server/session/test_surroundings.h"

namespace procgen {
namespace {

TEST(AlarmTest, RingsWhenItsTimeHasCome) {
  TestClock clock;
  absl::Notification rung;
  absl::Time time;
  Alarm alarm([&] { return clock.Now(); },
              [&](absl::Time now) {
                time = now;
                rung.Notify();
                return absl::InfiniteFuture();
              });
  alarm.RingBy(clock.Now());
  rung.WaitForNotification();
  EXPECT_EQ(time, clock.Now());
}

TEST(AlarmTest, RingsAgainWhenTheRingAsksForIt) {
  absl::Notification rung_twice;
  int count = 0;
  Alarm alarm(SteadyNow, [&](absl::Time now) {
    if (++count == 2) {
      rung_twice.Notify();
    }
    return count < 2 ? now : absl::InfiniteFuture();
  });
  alarm.RingBy(absl::InfinitePast());
  rung_twice.WaitForNotification();
}

TEST(AlarmTest, AnEarlierTimeGoesBeforeALaterOne) {
  TestClock clock;
  absl::Notification rung;
  Alarm alarm([&] { return clock.Now(); },
              [&](absl::Time) {
                rung.Notify();
                return absl::InfiniteFuture();
              });
  alarm.RingBy(clock.Now() + absl::Hours(1));
  alarm.RingBy(clock.Now());
  alarm.RingBy(clock.Now() + absl::Hours(2));
  rung.WaitForNotification();
}

TEST(AlarmTest, EndsWithoutRinging) {
  Alarm alarm(SteadyNow, [](absl::Time) {
    ADD_FAILURE() << "it rang";
    return absl::InfiniteFuture();
  });
  alarm.RingBy(SteadyNow() + absl::Hours(1));
}

}  // namespace
}  // namespace procgen
