#include "envcore/render/raster/thin_line.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/text_canvas.h"

namespace procgen {
namespace {

std::string Line(const Point& start, const Point& end) {
  TextCanvas canvas(5);
  EmitLine(start, end, 5, canvas);
  return canvas.Text();
}

TEST(ThinLineTest, BothEndsAreDrawn) {
  EXPECT_EQ(Line({1, 1}, {3, 3}), R"(
.....
.#...
..#..
...#.
.....
)");
}

TEST(ThinLineTest, IsTheSameFromEitherEnd) {
  EXPECT_EQ(Line({0, 1}, {4, 2}), Line({4, 2}, {0, 1}));
  EXPECT_EQ(Line({1, 0}, {2, 4}), Line({2, 4}, {1, 0}));
}

TEST(ThinLineTest, ALineOfOnePointIsOnePixel) {
  EXPECT_EQ(Line({2.4, 3.6}, {2.4, 3.6}), R"(
.....
.....
.....
.....
..#..
)");
}

TEST(ThinLineTest, IsClippedToTheCanvas) {
  EXPECT_EQ(Line({-100, 2}, {100, 2}), R"(
.....
.....
#####
.....
.....
)");
  EXPECT_EQ(Line({-100, -100}, {-50, 200}), Line({70, 70}, {80, 90}));
}

}  // namespace
}  // namespace procgen
