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

TEST(FlatRectangleTest, AntialiasedEdgesAreWeightedByCoverage) {
  TextFrame frame(4);
  DrawFlatAntialiased({0.5, 1, 2, 1}, {200, 200, 200, 255}, frame.frame());
  EXPECT_EQ(frame.At(0, 1).red, Mul(200, 127));
  EXPECT_EQ(frame.At(1, 1).red, 200);
  EXPECT_EQ(frame.At(2, 1).red, Mul(200, 127));
  EXPECT_EQ(frame.At(1, 0).red, 0);
}

}  // namespace
}  // namespace procgen
