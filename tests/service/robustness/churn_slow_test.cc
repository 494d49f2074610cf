// As churn_test.cc, with more rounds.

#include "gtest/gtest.h"
#include "tests/service/robustness/churn.h"

namespace procgen {
namespace {

// Growth without a leak: caches of libraries.
constexpr int64_t kSettlingBytes = 16 << 20;

TEST(ChurnSlowTest, MemoryAndFilesDoNotGrowOverTenThousandPools) {
  ChurnPools(500);
  const ProcessResources before = ResourcesInUse();
  ChurnPools(10'000);
  const ProcessResources after = ResourcesInUse();
  EXPECT_LT(after.memory_bytes, before.memory_bytes + kSettlingBytes);
  EXPECT_LE(after.file_count, before.file_count);
}

}  // namespace
}  // namespace procgen
