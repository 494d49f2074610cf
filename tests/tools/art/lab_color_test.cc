#include "tools/art/lab_color.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::FloatNear;

void ExpectLab(const Rgba& pixel, float lightness, float a, float b) {
  const LabColor color = ToLab(pixel);
  EXPECT_THAT(color.lightness, FloatNear(lightness, 0.1F));
  EXPECT_THAT(color.a, FloatNear(a, 0.1F));
  EXPECT_THAT(color.b, FloatNear(b, 0.1F));
}

TEST(LabColorTest, ColorsAreWhereTheStandardHasThem) {
  ExpectLab({255, 255, 255, 255}, 100, 0, 0);
  ExpectLab({0, 0, 0, 255}, 0, 0, 0);
  ExpectLab({255, 0, 0, 255}, 53.24F, 80.09F, 67.20F);
  ExpectLab({0, 0, 255, 255}, 32.30F, 79.19F, -107.86F);
  ExpectLab({8, 8, 8, 255}, 2.19F, 0, 0);  // nearly black
}

TEST(LabColorTest, TheDifferenceIsTheDistance) {
  EXPECT_FLOAT_EQ(ColorDifference({50, 3, 4}, {50, 0, 0}), 5);
  EXPECT_FLOAT_EQ(ColorDifference({100, 0, 0}, {0, 0, 0}), 100);
}

}  // namespace
}  // namespace procgen
