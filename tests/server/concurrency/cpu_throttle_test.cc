#include "server/concurrency/cpu_throttle.h"

#include <atomic>
#include <thread>
#include <vector>

#include "absl/time/clock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

// Threads that keep all cores busy during the object's life.
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

// Computes for `duration`.
void Work(absl::Duration duration) {
  for (const absl::Time end = absl::Now() + duration; absl::Now() < end;) {
  }
}

TEST(CpuThrottleTest, RestIsDueUnderContention) {
  const BusyMachine busy;
  absl::Duration rest;
  while (rest == absl::ZeroDuration()) {  // until another thread has used the core
    const CpuThrottle throttle;
    Work(absl::Milliseconds(20));
    rest = throttle.RestDue();
  }
  EXPECT_GT(rest, absl::ZeroDuration());
}

TEST(CpuThrottleTest, RestLeavesOneInTwoHundredOfTheMachine) {
  const absl::Duration work = absl::Milliseconds(10);
  EXPECT_EQ(work + CpuThrottle::RestAfter(work, 1), absl::Seconds(2));
  EXPECT_EQ(work + CpuThrottle::RestAfter(work, 2), absl::Seconds(1));
  EXPECT_EQ(work + CpuThrottle::RestAfter(work, 16), absl::Milliseconds(120));
  EXPECT_EQ(CpuThrottle::RestAfter(work, 256), absl::ZeroDuration());
  EXPECT_EQ(CpuThrottle::RestAfter(work, 0), CpuThrottle::RestAfter(work, 1))
      << "their count is unknown";
  EXPECT_EQ(CpuThrottle::RestAfter(absl::Seconds(1), 2), absl::Seconds(2)) << "the maximum";
}

}  // namespace
}  // namespace procgen
