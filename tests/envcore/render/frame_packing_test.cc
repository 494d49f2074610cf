#include "envcore/render/frame_packing.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gtest/gtest.h"

namespace procgen {
namespace {

// Lengths around the sixteen pixels that are packed at once.
TEST(FramePackingTest, EveryPixelLosesItsAlpha) {
  for (size_t count = 0; count <= 67; ++count) {
    std::vector<Rgba> pixels;
    std::vector<uint8_t> expected;
    for (size_t i = 0; i < count; ++i) {
      const auto value = static_cast<uint8_t>(i);
      pixels.push_back(
          {value, static_cast<uint8_t>(value + 100), static_cast<uint8_t>(value + 180), 7});
      expected.push_back(pixels.back().red);
      expected.push_back(pixels.back().green);
      expected.push_back(pixels.back().blue);
    }
    std::vector<uint8_t> rgb(3 * count + 1, 99);
    PackRgb(pixels, absl::MakeSpan(rgb).subspan(0, 3 * count));
    EXPECT_EQ(rgb.back(), 99) << count;
    rgb.pop_back();
    EXPECT_EQ(rgb, expected) << count;
  }
}

}  // namespace
}  // namespace procgen
