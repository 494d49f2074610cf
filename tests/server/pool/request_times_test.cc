#include "server/pool/request_times.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(RequestTimesTest, PercentilesCoverTheLatestRequests) {
  RequestTimes times;
  for (int i = 1; i <= 100; ++i) {
    times.Add(absl::Milliseconds(i));
  }
  EXPECT_EQ(times.Read().p50, absl::Milliseconds(50));
  EXPECT_EQ(times.Read().p99, absl::Milliseconds(99));
  for (size_t i = 0; i < RequestTimes::kRecentCount; ++i) {
    times.Add(absl::Milliseconds(7));
  }
  const RequestTimes::Summary summary = times.Read();
  EXPECT_EQ(summary.count, 612);
  EXPECT_EQ(summary.sum, absl::Milliseconds(5050 + 7 * 512));
  EXPECT_EQ(summary.p50, absl::Milliseconds(7));
  EXPECT_EQ(summary.p99, absl::Milliseconds(7));
}

}  // namespace
}  // namespace procgen
