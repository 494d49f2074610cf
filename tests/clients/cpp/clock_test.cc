// Deadlines of the C++ client while the wall clock moves. A separate program, because it replaces
// the clock of the whole process.

#include "absl/time/clock.h"

#include <sys/syscall.h>
#include <time.h>  // NOLINT(modernize-deprecated-headers): clock_gettime is not in <ctime>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/cpp/server_fixture.h"
#include "tests/service/robustness/fault_proxy.h"

namespace {

std::atomic<int64_t> set_by_seconds = 0;

}  // namespace

extern "C" int ReadSetClock(clockid_t clock, timespec* time) noexcept {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (clock == CLOCK_REALTIME) {
    time->tv_sec += set_by_seconds;
  }
  return result;
}

// Interposes clock_gettime.
extern "C" int clock_gettime(clockid_t, timespec*) noexcept
    __attribute__((visibility("default"), alias("ReadSetClock")));

namespace procgen {
namespace {

class ClockTest : public ServerTest {};

TEST_F(ClockTest, ReconnectTimesOutDespiteAClockChange) {
  procgen_client::RemotePoolOptions options;
  options.recovery.reconnect_timeout = absl::Milliseconds(500);
  auto proxy = std::make_unique<FaultProxy>(FaultProxy::Options{.target = server_->address()});
  const auto pool = CreatePool(MazeOptions(1), options, proxy->address());
  proxy = nullptr;
  std::thread setter([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    set_by_seconds = -3600;
  });
  const absl::Time set_from = absl::Now();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(pool->Step({.count = 1, .steps = false}, {}, {}),
              StatusIs(absl::StatusCode::kUnavailable, testing::_));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  setter.join();
  EXPECT_LT(absl::Now(), set_from);
  set_by_seconds = 0;
}

}  // namespace
}  // namespace procgen
