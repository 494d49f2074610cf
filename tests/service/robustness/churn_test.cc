// Learners that leave in every bad way leave nothing behind.

#include "tests/service/robustness/churn.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

// Growth of a process that leaks nothing: the memory of libraries settles.
constexpr int64_t kSettlingBytes = 16 << 20;

TEST(ChurnTest, MemoryAndFilesDoNotGrow) {
  ChurnPools(60);
  const ProcessResources before = SettledHoldings();
  ChurnPools(240);
  const ProcessResources after = SettledHoldings();
  EXPECT_LT(after.memory_bytes, before.memory_bytes + kSettlingBytes);
  EXPECT_LE(after.file_count, before.file_count);
}

}  // namespace
}  // namespace procgen
