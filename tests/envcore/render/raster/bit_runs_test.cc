#include "envcore/render/raster/bit_runs.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(BitRangeTest, IsClippedToAWord) {
  EXPECT_EQ(BitRange(-5, 3), 0b111U);
  EXPECT_EQ(BitRange(62, 99), uint64_t{3} << 62);
  EXPECT_EQ(BitRange(-9, 99), ~uint64_t{0});
  EXPECT_EQ(BitRange(-9, 0), 0U);
  EXPECT_EQ(BitRange(64, 70), 0U);
  EXPECT_EQ(BitRange(5, 4), 0U);
}

std::string RunsOf(uint64_t bits) {
  std::string runs;
  ForEachBitRun(bits, [&](int first, int end) { absl::StrAppend(&runs, first, "-", end, " "); });
  return runs;
}

TEST(BitRunsTest, ReturnsTheRunsOfOnes) {
  EXPECT_EQ(RunsOf(0), "");
  EXPECT_EQ(RunsOf(~uint64_t{0}), "0-64 ");
  EXPECT_EQ(RunsOf(0b1101110U), "1-4 5-7 ");
  EXPECT_EQ(RunsOf(uint64_t{1} << 63 | 1), "0-1 63-64 ");
}

}  // namespace
}  // namespace procgen
