// Two dozen learners that connect and disconnect abruptly, with every encoding, for half an hour
// or PROCGEN_SOAK_SECONDS. Each receives an uninterrupted trace, and the server's memory does not
// grow.

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/robustness/broken_connection.h"
#include "tests/service/robustness/churn.h"
#include "tests/service/robustness/fault_proxy.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/server_process.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int kLearnerCount = 24;
constexpr size_t kTraceMax = 120;  // responses per learner
// Growth without a leak: the number of pools varies, and each takes several times as much memory
// under a sanitizer.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int64_t kGrowthBytes = 96 << 20;
#else
constexpr int64_t kGrowthBytes = 24 << 20;
#endif

absl::Duration SoakLength() {
  const char* seconds = std::getenv("PROCGEN_SOAK_SECONDS");
  return seconds == nullptr ? absl::Minutes(30) : absl::Seconds(std::atoi(seconds));
}

// Runs one learner after another until `end`.
class Learners {
 public:
  Learners(std::string address, const std::vector<size_t>& expected, uint32_t seed)
      : address_(std::move(address)), expected_(expected), random_(seed) {}

  void RunUntil(absl::Time end) {
    for (; absl::Now() < end && !testing::Test::HasFailure(); ++count_) {
      PlayOverAFaultyNetwork();
      DropPool(address_, random_());
    }
  }

  int count() const { return count_; }
  int break_count() const { return break_count_; }

 private:
  void PlayOverAFaultyNetwork() {
    const v1::Encoding encoding = random_() % 2 == 0 ? v1::ENCODING_RAW : v1::ENCODING_DELTA_ZSTD;
    FaultProxy::Options options = FaultyNetwork(address_, uint32_t(random_()), encoding);
    options.bytes_between_faults *= 2;
    FaultProxy proxy(options);
    const size_t length = 1 + random_() % kTraceMax;
    const std::vector<size_t> trace = TraceAt(
        proxy.address(), encoding, [&](size_t responses) { return responses < length; },
        [&] { proxy.SetFaults(true); });
    EXPECT_THAT(trace, testing::ElementsAreArray(expected_.begin(),
                                                 expected_.begin() + static_cast<int>(length)));
    break_count_ += proxy.break_count();
  }

  const std::string address_;
  const std::vector<size_t>& expected_;
  std::mt19937 random_;
  int count_ = 0;
  int break_count_ = 0;
};

// Peak memory of the process until `end`.
int64_t PeakUntil(absl::Time end, pid_t process) {
  int64_t peak = 0;
  while (absl::Now() < end) {
    peak = std::max(peak, ProcessResources::Of(process).memory_bytes);
    absl::SleepFor(absl::Milliseconds(200));
  }
  return peak;
}

TEST(SoakTest, AbruptLearnersReceiveTheirTracesWithoutLeaks) {
  ReturnFreedMemoryAtOnce();
  // Few log lines, because nothing reads the pipe.
  ServerProcess server({"--address=127.0.0.1:0", "--workers=2", "--log_level=error"});
  const std::string address = server.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const std::vector<size_t> expected = TraceAt(
      address, v1::ENCODING_RAW, [](size_t responses) { return responses < kTraceMax; }, [] {});
  const int64_t files = ProcessResources::Of(server.process_id()).file_count;

  const absl::Time begin = absl::Now();
  const absl::Duration length = SoakLength();
  std::vector<Learners> learners;
  learners.reserve(kLearnerCount);
  std::vector<std::thread> threads;
  for (uint32_t seed = 1; seed <= kLearnerCount; ++seed) {
    learners.emplace_back(address, expected, seed);
    threads.emplace_back([&, seed] { learners[seed - 1].RunUntil(begin + length); });
  }
  const int64_t first_peak = PeakUntil(begin + length / 2, server.process_id());
  const int64_t last_peak = PeakUntil(begin + length, server.process_id());
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_LT(last_peak, first_peak + kGrowthBytes);
  // Pools and connections end a little later than their clients.
  while ((*client)->GetLoad()->pool_count() > 0 ||
         ProcessResources::Of(server.process_id()).file_count > files) {
    absl::SleepFor(absl::Milliseconds(20));
  }
  int count = 0;
  int break_count = 0;
  for (const Learners& one : learners) {
    count += one.count();
    break_count += one.break_count();
  }
  std::printf("%d learners, %d broken connections; most memory in bytes: %ld, then %ld\n", count,
              break_count, first_peak, last_peak);
  EXPECT_GT(break_count, 0);
}

}  // namespace
}  // namespace procgen
