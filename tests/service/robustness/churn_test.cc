// Learners that disconnect abruptly leak nothing.

#include "tests/service/robustness/churn.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

// Growth without a leak: caches of libraries.
constexpr int64_t kSettlingBytes = 16 << 20;

void ExpectNoGrowth(size_t rounds_before, size_t rounds) {
  ChurnPools(rounds_before);
  const ProcessResources before = ResourcesInUse();
  ChurnPools(rounds);
  const ProcessResources after = ResourcesInUse();
  EXPECT_LT(after.memory_bytes, before.memory_bytes + kSettlingBytes);
  EXPECT_LE(after.file_count, before.file_count);
}

TEST(ChurnTest, MemoryAndFilesDoNotGrow) { ExpectNoGrowth(60, 240); }

TEST(ChurnSlowTest, MemoryAndFilesDoNotGrowOverTenThousandPools) { ExpectNoGrowth(500, 10'000); }

}  // namespace
}  // namespace procgen
