#include "server/session/polite_thread.h"

#include <atomic>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/session/alarm.h"

namespace procgen {
namespace {

// Threads that want all cores, as long as this lives.
class BusyMachine {
 public:
  BusyMachine() {
    for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency(); ++i) {
      threads_.emplace_back([this] {
        while (!ends_) {
        }
      });
    }
  }
  ~BusyMachine() {
    ends_ = true;
    for (std::thread& thread : threads_) {
      thread.join();
    }
  }

 private:
  std::atomic<bool> ends_ = false;
  std::vector<std::thread> threads_;
};

TEST(PoliteThreadTest, WorksInOrder) {
  std::vector<int> done;
  {
    PoliteThread thread;
    for (int i = 0; i < 3; ++i) {
      thread.Run([&done, i] { done.push_back(i); });
    }
  }
  EXPECT_THAT(done, testing::ElementsAre(0, 1, 2));
}

TEST(PoliteThreadTest, RestsWhereOthersWantItsCore) {
  const BusyMachine busy;
  PoliteThread thread;
  EXPECT_LT(thread.rests_until(), SteadyNow());
  // As long as it takes until another has been given the core.
  while (thread.rests_until() < SteadyNow()) {
    absl::Notification done;
    thread.Run([&done] {
      for (const absl::Time end = absl::Now() + absl::Milliseconds(20); absl::Now() < end;) {
      }
    });
    thread.Run([&done] { done.Notify(); });
    done.WaitForNotification();
  }
}

TEST(PoliteThreadTest, TakesOneInTwoHundredOfTheMachine) {
  const absl::Duration work = absl::Milliseconds(10);
  EXPECT_EQ(work + PoliteThread::RestAfter(work, 1), absl::Seconds(2));
  EXPECT_EQ(work + PoliteThread::RestAfter(work, 2), absl::Seconds(1));
  EXPECT_EQ(work + PoliteThread::RestAfter(work, 16), absl::Milliseconds(120));
  EXPECT_EQ(PoliteThread::RestAfter(work, 256), absl::ZeroDuration());
  EXPECT_EQ(work + PoliteThread::RestAfter(work, 0), absl::Seconds(2)) << "their count is unknown";
}

}  // namespace
}  // namespace procgen
