// As churn_test.cc, for longer.

#include "gtest/gtest.h"
#include "tests/service/robustness/churn.h"

namespace procgen {
namespace {

// Growth of a process that leaks nothing: the memory of libraries settles.
constexpr int64_t kSettlingBytes = 16 << 20;

TEST(ChurnSlowTest, MemoryAndFilesDoNotGrowOverTenThousandPools) {
  ChurnPools(500);
  const ProcessResources before = SettledHoldings();
  ChurnPools(10'000);
  const ProcessResources after = SettledHoldings();
  EXPECT_LT(after.memory_bytes, before.memory_bytes + kSettlingBytes);
  EXPECT_LE(after.file_count, before.file_count);
}

}  // namespace
}  // namespace procgen
