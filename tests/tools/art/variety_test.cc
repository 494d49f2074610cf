// Measured with flat colors, whose values are known.

#include "tools/art/variety.h"

#include <cstdint>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::DoubleNear;

constexpr int kSidePx = 4;

// A view with columns of two grays.
std::vector<uint8_t> Columns(uint8_t even, uint8_t odd) {
  std::vector<uint8_t> rgb;
  for (int i = 0; i < kSidePx * kSidePx; ++i) {
    rgb.insert(rgb.end(), 3, i % 2 == 0 ? even : odd);
  }
  return rgb;
}

TEST(VarietyTest, ColumnsOfBlackAndWhiteHaveTheLargestContrastAndGrain) {
  const ViewColors colors = ColorsOf(Columns(0, 255), kSidePx);
  EXPECT_THAT(colors.lightness, DoubleNear(50, 0.1));
  EXPECT_THAT(colors.contrast, DoubleNear(50, 0.1));
  EXPECT_THAT(colors.grain, DoubleNear(100, 0.1));
  EXPECT_THAT(colors.chroma, DoubleNear(0, 0.1));
}

TEST(VarietyTest, ABlackColumnBesideAWhiteRowEndIsNoGrain) {
  std::vector<uint8_t> rows;
  for (int row = 0; row < kSidePx; ++row) {
    rows.insert(rows.end(), 3 * kSidePx, row % 2 == 0 ? 0 : 255);
  }
  EXPECT_THAT(ColorsOf(rows, kSidePx).grain, DoubleNear(0, 0.01));
}

TEST(VarietyTest, EqualViewsHaveNoSpread) {
  const ViewColors view = ColorsOf(Columns(40, 90), kSidePx);
  const Variety variety = SpreadOf({view, view});
  EXPECT_THAT(variety.lightness, DoubleNear(view.lightness, 1e-9));
  EXPECT_THAT(variety.lightness_spread, DoubleNear(0, 1e-4));
  EXPECT_THAT(variety.color_spread, DoubleNear(0, 1e-4));
  EXPECT_THAT(variety.hue_spread, DoubleNear(0, 1e-4));
}

TEST(VarietyTest, SpreadsAreStandardDeviations) {
  const Variety variety =
      SpreadOf({{.lightness = 20, .a = 10, .b = 0}, {.lightness = 60, .a = 0, .b = 10}});
  EXPECT_THAT(variety.lightness, DoubleNear(40, 1e-9));
  EXPECT_THAT(variety.lightness_spread, DoubleNear(20, 1e-9));
  EXPECT_THAT(variety.color_spread, DoubleNear(21.21, 0.01));  // of 20, 5 and 5
  EXPECT_THAT(variety.hue_spread, DoubleNear(47.7, 0.1));      // hues of 0 and 90 degrees
}

}  // namespace
}  // namespace procgen
