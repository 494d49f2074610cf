#include "envcore/render/output/pixel.h"

#include <limits>

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(PixelTest, LayOverDoesNotOverflow) {
  for (uint32_t a = 0; a < 256; ++a) {
    for (uint32_t below = 0; below < 256; ++below) {
      EXPECT_LE(Mul(255, a) + Mul(below, 255 - a), 255U);
    }
  }
}

TEST(PixelTest, FourChannelsAreMultipliedLikeOne) {
  for (uint32_t c = 0; c < 256; ++c) {
    for (uint32_t a = 0; a < 256; ++a) {
      const auto channel = [c](uint32_t shift) { return static_cast<uint8_t>(c + shift); };
      const Rgba product = Mul(Rgba{channel(0), channel(60), channel(130), channel(200)}, a);
      ASSERT_EQ(product, (Rgba{Mul(channel(0), a), Mul(channel(60), a), Mul(channel(130), a),
                               Mul(channel(200), a)}))
          << c << " * " << a;
    }
  }
}

TEST(PixelTest, HalvesAreRoundedUp) {
  EXPECT_EQ(RoundPx(0.5), 1);
  EXPECT_EQ(RoundPx(-0.5), 0);
  EXPECT_EQ(RoundPx(-0.51), -1);
  EXPECT_EQ(RoundPx(-3), -3);
  EXPECT_EQ(RoundPx(1e300), 1000000000);
  EXPECT_EQ(RoundPx(-1e300), -1000000000);
  EXPECT_EQ(RoundPx(std::numeric_limits<double>::quiet_NaN()), -1000000000);
}

TEST(PixelTest, OpacityHas256Steps) {
  EXPECT_EQ(OpacityFactor(1), 255U);
  EXPECT_EQ(OpacityFactor(0.99999F), 254U);  // 255 of 256 steps
  EXPECT_EQ(OpacityFactor(0.5F), 127U);
  EXPECT_EQ(OpacityFactor(0), 0U);
  EXPECT_EQ(OpacityFactor(-1), 0U);
  EXPECT_EQ(OpacityFactor(7), 255U);
}

}  // namespace
}  // namespace procgen
