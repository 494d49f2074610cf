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

TEST(EllipseTest, InsideHasThePixelsWhoseCentersAreInside) {
  constexpr int kSide = 40;
  const ScreenRect rect = {3.3, 5.7, 30.4, 22.9};
  std::string expected = "\n";
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double dx = (x + 0.5 - rect.x - rect.width / 2) / (rect.width / 2);
      const double dy = (y + 0.5 - rect.y - rect.height / 2) / (rect.height / 2);
      expected += dx * dx + dy * dy < 1 ? '#' : '.';
    }
    expected += '\n';
  }
  const std::string drawn = Inside(rect, kSide);
  int different = 0;
  for (size_t i = 0; i < drawn.size(); ++i) {
    different += drawn[i] != expected[i] ? 1 : 0;
  }
  EXPECT_LE(different, 6) << drawn;  // the curves are flattened
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

TEST(EllipseTest, InFlatEllipsesTheInsideOfALaterRowCoversTheOutline) {
  std::string text = "\n........\n........\n........\n";
  const auto paint = [&text](char letter) {
    return [&text, letter](int row, int first, int end) {
      for (int x = first; x < end; ++x) {
        const int place = 1 + row * 9 + x;
        text[static_cast<size_t>(place)] = letter;
      }
    };
  };
  // A canvas of 8 x 8 of which the first three rows are painted.
  EmitEllipse({0, 0, 7, 1}, 8, paint('i'), paint('o'));
  EXPECT_EQ(text, R"(
oooooooo
iiiiiiii
........
)");
}

// The outline is not symmetric: the connection of two pieces depends on the drawing direction.
TEST(EllipseTest, OutlineIsClosed) {
  const std::string outline = Outline({1.3, 1.3, 7.4, 7.4}, 10);
  EXPECT_EQ(outline, R"(
..........
...####...
..#....#..
.#......#.
.#......#.
.#......#.
.#......#.
..#.....#.
...#####..
..........
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
