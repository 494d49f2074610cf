#include "envcore/scene/camera.h"

#include "envcore/random/random_stream.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

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
