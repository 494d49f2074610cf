#include "envcore/render/raster/ellipse.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

std::string Inside(const ScreenRect& rect, int size_px) {
  TextCanvas canvas(size_px);
  EmitEllipseInside(rect, size_px, canvas);
  return canvas.Text();
}

std::string Outline(const ScreenRect& rect, int size_px) {
  TextCanvas canvas(size_px);
  EmitEllipse(
      rect, size_px, [](int, int, int) {}, canvas);
  return canvas.Text();
}

// Computed by hand: the runs X = 0 to 1 at Y = 3, X = 2 at Y = 2, X = 3 at Y = 1 and 0. The center
// is column 4 and row 4, so the outline is one pixel wider and higher than the rectangle.
TEST(EllipseTest, WholePixelsFollowTheMidpointMethod) {
  EXPECT_EQ(Outline({1, 1, 6, 6}, 8), R"(
........
...###..
..#...#.
.#.....#
.#.....#
.#.....#
..#...#.
...###..
)");
}

TEST(EllipseTest, WithoutAnOutlineTheInsideKeepsItsBounds) {
  EXPECT_EQ(Inside({1, 1, 6, 6}, 8), R"(
........
........
..####..
.######.
.######.
.######.
..####..
........
)");
}

TEST(EllipseTest, IsClippedToTheCanvas) {
  EXPECT_EQ(Inside({-20.5, -20.5, 41, 41}, 2), "\n##\n##\n");
  EXPECT_EQ(Inside({30.5, 0.5, 3, 3}, 2), "\n..\n..\n");
  EXPECT_EQ(Outline({30.5, 0.5, 3, 3}, 2), "\n..\n..\n");
  EXPECT_EQ(Inside({-30, 0, 3, 3}, 2), "\n..\n..\n");
}

TEST(EllipseTest, EmptyRectanglesEmitNothing) {
  EXPECT_EQ(Inside({0.5, 0.5, 0, 1}, 2), "\n..\n..\n");
  EXPECT_EQ(Outline({0, 0, 1, -1}, 2), "\n..\n..\n");
  EXPECT_EQ(Outline({0, 0, std::nan(""), 1}, 2), "\n..\n..\n");
}

}  // namespace
}  // namespace procgen
