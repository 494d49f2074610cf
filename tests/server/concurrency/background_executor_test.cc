#include "server/concurrency/background_executor.h"

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <string>
#include <system_error>
#include <vector>

#include "absl/synchronization/blocking_counter.h"
#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using testing::ElementsAre;

// The order in which one thread executes tasks that were submitted while it was busy. The owner of
// a task is its name without the digit.
std::vector<std::string> OrderOf(const std::vector<std::string>& submitted) {
  std::vector<std::string> order;
  absl::Notification is_busy;
  absl::Notification all_are_submitted;
  BackgroundExecutor executor(1);
  executor.Run("", [&] {
    is_busy.Notify();
    all_are_submitted.WaitForNotification();
  });
  is_busy.WaitForNotification();
  absl::BlockingCounter left(static_cast<int>(submitted.size()));
  for (const std::string& name : submitted) {
    executor.Run(name.substr(0, name.size() - 1), [&, name] {
      order.push_back(name);
      left.DecrementCount();
    });
  }
  all_are_submitted.Notify();
  left.Wait();
  return order;
}

TEST(BackgroundExecutorTest, AllWorkIsDoneBeforeItEnds) {
  std::atomic<int> count = 0;
  {
    BackgroundExecutor executor(2);
    for (int i = 0; i < 100; ++i) {
      executor.Run(std::to_string(i % 3), [&] { ++count; });
    }
  }
  EXPECT_EQ(count, 100);
}

TEST(BackgroundExecutorTest, OwnersAreServedInTurn) {
  EXPECT_THAT(OrderOf({"alice1", "alice2", "alice3", "alice4", "bob1", "bob2", "carol1"}),
              ElementsAre("alice1", "bob1", "carol1", "alice2", "bob2", "alice3", "alice4"));
}

TEST(BackgroundExecutorTest, WorkWithoutOwnerHasItsOwnQueue) {
  EXPECT_THAT(OrderOf({"alice1", "alice2", "1", "2"}), ElementsAre("alice1", "1", "alice2", "2"));
}

TEST(BackgroundExecutorTest, WorkMaySubmitWork) {
  absl::Notification done;
  BackgroundExecutor executor(1);
  executor.Run("a", [&] { executor.Run("b", [&] { done.Notify(); }); });
  done.WaitForNotification();
}

// A child process that may not start threads.
TEST(BackgroundExecutorDeathTest, WithoutThreadsItThrowsAndLeavesNone) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        const rlimit none = {};
        setrlimit(RLIMIT_NPROC, &none);
        if (geteuid() == 0 && setuid(65534) != 0) {  // root has no limit
          _exit(1);
        }
        try {
          BackgroundExecutor executor(2);
        } catch (const std::system_error&) {
          _exit(7);
        }
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace procgen
