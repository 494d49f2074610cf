// Learners that disconnect abruptly leak nothing.

#include "tests/service/robustness/churn.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

// Growth without a leak: caches of libraries.
constexpr int64_t kSettlingBytes = 16 << 20;

TEST(ChurnTest, MemoryAndFilesDoNotGrow) {
  ChurnPools(60);
  const ProcessResources before = ResourcesInUse();
  ChurnPools(240);
  const ProcessResources after = ResourcesInUse();
  EXPECT_LT(after.memory_bytes, before.memory_bytes + kSettlingBytes);
  EXPECT_LE(after.file_count, before.file_count);
}

}  // namespace
}  // namespace procgen
