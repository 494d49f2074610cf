#include "envcore/render/pixel.h"

#include <array>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

TEST(PixelTest, MulIsExactAtBothEnds) {
  for (uint32_t c = 0; c < 256; ++c) {
    EXPECT_EQ(Mul(c, 255), c);
    EXPECT_EQ(Mul(c, 0), 0);
  }
}

TEST(PixelTest, MulRoundsAsTheRulesSay) { EXPECT_EQ(Mul(200, 100), 78); }

TEST(PixelTest, LayingOverNeverOverflows) {
  for (uint32_t a = 0; a < 256; ++a) {
    for (uint32_t below = 0; below < 256; ++below) {
      EXPECT_LE(Mul(255, a) + Mul(below, 255 - a), 255U);
    }
  }
}

TEST(PixelTest, LayingOverKeepsWhatATransparentPixelCovers) {
  std::array<uint8_t, 3> below = {1, 127, 255};
  LayOver({0, 0, 0, 0}, below.data());
  EXPECT_THAT(below, ElementsAre(1, 127, 255));
}

TEST(PixelTest, LayingOverReplacesWhatAnOpaquePixelCovers) {
  std::array<uint8_t, 3> below = {1, 127, 255};
  LayOver({4, 5, 6, 255}, below.data());
  EXPECT_THAT(below, ElementsAre(4, 5, 6));
}

TEST(PixelTest, HalvesAreRoundedUp) {
  EXPECT_EQ(RoundPx(0.5), 1);
  EXPECT_EQ(RoundPx(-0.5), 0);
  EXPECT_EQ(RoundPx(-0.51), -1);
}

TEST(PixelTest, OpacityIsCutIntoSteps) {
  EXPECT_EQ(OpacityFactor(1), 255U);
  EXPECT_EQ(OpacityFactor(0.99999F), 254U);  // 255 of 256 steps
  EXPECT_EQ(OpacityFactor(0.5F), 127U);
  EXPECT_EQ(OpacityFactor(0), 0U);
  EXPECT_EQ(OpacityFactor(-1), 0U);
  EXPECT_EQ(OpacityFactor(7), 255U);
}

}  // namespace
}  // namespace procgen
