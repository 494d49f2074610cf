#include "envcore/scene/camera.h"

#include "envcore/random/random_stream.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

void ExpectRect(const ScreenRect& rect, float x, float y, float width, float height) {
  EXPECT_FLOAT_EQ(static_cast<float>(rect.x), x);
  EXPECT_FLOAT_EQ(static_cast<float>(rect.y), y);
  EXPECT_FLOAT_EQ(static_cast<float>(rect.width), width);
  EXPECT_FLOAT_EQ(static_cast<float>(rect.height), height);
}

// A world of 16 x 16 cells that is completely in view: 4 pixels per cell.
Viewport WholeWorld(int size_px = 64) {
  return Viewport({.center_x = 8, .center_y = 8, .cells = 16}, size_px);
}

TEST(ViewportTest, TheWholeWorldFillsTheImage) {
  EXPECT_EQ(WholeWorld().pixels_per_cell(), 4);
  EXPECT_EQ(WholeWorld().cells(), 16);
  ExpectRect(WholeWorld().InWorld(0, 16, 16, 16, 0), 0, 0, 64, 64);
}

TEST(ViewportTest, TheScreensYPointsDown) {
  ExpectRect(WholeWorld().OfBox(1, 15, 1, 1), 0, 0, 8, 8);
  ExpectRect(WholeWorld().OfBox(1, 1, 1, 1), 0, 56, 8, 8);
}

TEST(ViewportTest, CellsAreDrawnSlightlyEnlarged) {
  ExpectRect(WholeWorld().OfCell(2, 3), 8 - 0.08F, 48 - 0.08F, 4.16F, 4.16F);
}

TEST(ViewportTest, TheCenterOfTheCameraIsTheCenterOfTheImage) {
  const Viewport view({.center_x = 100.5F, .center_y = 3.25F, .cells = 8}, 64);
  ExpectRect(view.OfBox(100.5F, 3.25F, 0.5F, 0.5F), 28, 28, 8, 8);
  ExpectRect(view.OfBox(101.5F, 3.25F, 0.5F, 0.5F), 36, 28, 8, 8);
  ExpectRect(view.OfBox(100.5F, 4.25F, 0.5F, 0.5F), 28, 20, 8, 8);
}

TEST(ViewportTest, FractionsOfTheImageIgnoreTheCameraAndAddTheHalfHeightToTheTop) {
  const Viewport view({.center_x = 100, .center_y = 50, .cells = 8}, 64);
  ExpectRect(view.OfShares(0.5F, 0.25F, 0.25F, 0.125F), 16, 24, 32, 16);
}

// The values of a camera differ by powers of two, so every f32 operation rounds equally.
TEST(ViewportTest, TheHumanViewIsExactlyEightTimesAsLarge) {
  RandomStream random(1);
  for (int i = 0; i < 1000; ++i) {
    const Camera camera = {.center_x = random.Range(0, 64),
                           .center_y = random.Range(0, 64),
                           .cells = static_cast<float>(random.Int(5, 65))};
    const float x = random.Range(0, 64);
    const float y = random.Range(0, 64);
    const float rx = random.Range(0, 4);
    const float ry = random.Range(0, 4);
    const ScreenRect small = Viewport(camera, 64).OfBox(x, y, rx, ry);
    const ScreenRect large = Viewport(camera, 512).OfBox(x, y, rx, ry);
    EXPECT_EQ(large.x, 8 * small.x);
    EXPECT_EQ(large.y, 8 * small.y);
    EXPECT_EQ(large.width, 8 * small.width);
    EXPECT_EQ(large.height, 8 * small.height);
  }
}

}  // namespace
}  // namespace procgen
