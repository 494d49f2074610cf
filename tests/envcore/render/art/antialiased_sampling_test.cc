#include "envcore/render/art/antialiased_sampling.h"

#include <numbers>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

MipmappedImage Grey(int side, uint8_t level) {
  Image image(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      image.At(x, y) = {level, level, level, 255};
    }
  }
  return {image, Levels::kOne};
}

TEST(AntialiasedSamplingTest, EdgesAreWeightedByCoverage) {
  TextFrame frame(8);
  DrawAntialiased(Grey(2, 200), {1.25, 2, 4, 4}, 0, 1, frame.frame());
  EXPECT_EQ(frame.At(1, 3).red, Mul(200, 191));
  EXPECT_EQ(frame.At(2, 3).red, 200);
  EXPECT_EQ(frame.At(5, 3).red, Mul(200, 63));
  EXPECT_EQ(frame.At(6, 3).red, 0);
}

TEST(AntialiasedSamplingTest, ColorsAreInterpolated) {
  Image image(2, 1);
  image.At(0, 0) = {0, 0, 0, 255};
  image.At(1, 0) = {200, 200, 200, 255};
  TextFrame frame(8);
  DrawAntialiased(MipmappedImage(image, Levels::kOne), {0, 0, 8, 8}, 0, 1, frame.frame());
  EXPECT_EQ(frame.At(0, 4).red, 0);
  EXPECT_GT(frame.At(4, 4).red, frame.At(3, 4).red);
  EXPECT_EQ(frame.At(7, 4).red, 200);
}

TEST(AntialiasedSamplingTest, AHalfTurnCoversTheSamePixels) {
  TextFrame frame(8);
  DrawAntialiased(Grey(4, 200), {2, 2, 4, 4}, std::numbers::pi_v<float>, 1, frame.frame());
  EXPECT_EQ(frame.At(2, 2).red, 200);
  EXPECT_EQ(frame.At(5, 5).red, 200);
  EXPECT_LE(frame.At(1, 3).red, 1);
  EXPECT_LE(frame.At(6, 3).red, 1);
}

TEST(AntialiasedSamplingTest, EmptyRectanglesAreNotDrawn) {
  TextFrame frame(4);
  DrawAntialiased(Grey(4, 200), {1, 1, 0, 2}, 0, 1, frame.frame());
  DrawAntialiased(Grey(4, 200), {1, 1, 2, -2}, 1, 1, frame.frame());
  EXPECT_EQ(frame.Text(), TextFrame(4).Text());
}

}  // namespace
}  // namespace procgen
