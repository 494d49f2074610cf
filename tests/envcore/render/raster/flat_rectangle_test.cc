#include "envcore/render/raster/flat_rectangle.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

constexpr Rgba kA = {'a', 0, 0, 255};

std::string Drawn(const ScreenRect& rect) {
  TextFrame frame(4);
  DrawFlatAliased(rect, kA, frame.frame());
  return frame.Text();
}

TEST(FlatRectangleTest, EdgesAreRoundedToPixelBorders) {
  EXPECT_EQ(Drawn({0.5, 0.49, 1.0, 1.0}), R"(
.a..
....
....
....
)");
}

TEST(FlatRectangleTest, NothingWhenBothEdgesRoundToTheSameBorder) {
  EXPECT_EQ(Drawn({0.6, 0, 0.8, 4}), Drawn({0, 0, 0, 0}));
}

TEST(FlatRectangleTest, NegativeSizesSwapTheEdges) {
  EXPECT_EQ(Drawn({3, 3, -2, -1}), R"(
....
....
.aa.
....
)");
}

TEST(FlatRectangleTest, IsClippedToTheFrame) {
  EXPECT_EQ(Drawn({-10, 2.5, 1e12, 1e12}), R"(
....
....
....
aaaa
)");
}

TEST(FlatRectangleTest, TranslucentColorsAreBlended) {
  TextFrame frame(1);
  DrawFlatAliased({0, 0, 1, 1}, {100, 0, 0, 255}, frame.frame());
  DrawFlatAliased({0, 0, 1, 1}, {255, 255, 255, 120}, frame.frame());
  EXPECT_EQ(frame.At(0, 0).red, 120 + Mul(100, 135));
  EXPECT_EQ(frame.At(0, 0).green, 120);
}

TEST(FlatRectangleTest, AntialiasedEdgesAreWeightedByCoverage) {
  TextFrame frame(4);
  DrawFlatAntialiased({0.5, 1, 2, 1}, {200, 200, 200, 255}, frame.frame());
  EXPECT_EQ(frame.At(0, 1).red, Mul(200, 127));
  EXPECT_EQ(frame.At(1, 1).red, 200);
  EXPECT_EQ(frame.At(2, 1).red, Mul(200, 127));
  EXPECT_EQ(frame.At(1, 0).red, 0);
}

TEST(FlatRectangleTest, MonochromeColorsFollowKindAndTheme) {
  EXPECT_EQ(MonochromeColor(0, 0), (Rgba{127, 255, 127, 255}));  // 29
  EXPECT_EQ(MonochromeColor(51, 0), (Rgba{191, 127, 63, 255}));  // 29 * 52 mod 64 = 36
  EXPECT_EQ(MonochromeColor(0, 1), (Rgba{255, 63, 63, 255}));    // 48
}

}  // namespace
}  // namespace procgen
