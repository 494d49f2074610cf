#include "envcore/render/output/frame_packing.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gtest/gtest.h"

namespace procgen {
namespace {

// Tests lengths around the eight pixels that are packed at once.
TEST(FramePackingTest, DropsTheAlphaOfEveryPixel) {
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
    PackFrame(pixels, Color::kRgb, Layout::kHwc, absl::MakeSpan(rgb).subspan(0, 3 * count));
    EXPECT_EQ(rgb.back(), 99) << count;
    rgb.pop_back();
    EXPECT_EQ(rgb, expected) << count;
  }
}

TEST(FramePackingTest, UnpackedPixelsAreOpaque) {
  for (size_t count = 0; count <= 35; ++count) {
    std::vector<uint8_t> rgb;
    std::vector<Rgba> expected;
    for (size_t i = 0; i < count; ++i) {
      expected.push_back({static_cast<uint8_t>(i), static_cast<uint8_t>(i + 100),
                          static_cast<uint8_t>(i + 180), 255});
      rgb.insert(rgb.end(), {expected.back().red, expected.back().green, expected.back().blue});
    }
    const Rgba untouched = {1, 2, 3, 4};
    std::vector<Rgba> pixels(count + 1, untouched);
    UnpackRgb(rgb, absl::MakeSpan(pixels).subspan(0, count));
    EXPECT_EQ(pixels.back(), untouched) << count;
    pixels.pop_back();
    EXPECT_TRUE(pixels == expected) << count;
  }
}

// Pixels with the extreme values of each channel, and values in between.
std::vector<Rgba> ManyPixels() {
  std::vector<Rgba> pixels;
  for (const int red : {0, 1, 77, 128, 254, 255}) {
    for (const int green : {0, 1, 150, 255}) {
      for (int blue = 0; blue < 256; blue += 5) {
        pixels.push_back({static_cast<uint8_t>(red), static_cast<uint8_t>(green),
                          static_cast<uint8_t>(blue), 255});
      }
    }
  }
  return pixels;
}

TEST(FramePackingTest, PlanesAreTheChannelsOneAfterTheOther) {
  const std::vector<Rgba> pixels = ManyPixels();
  const size_t count = pixels.size();
  std::vector<uint8_t> planes(3 * count);
  PackFrame(pixels, Color::kRgb, Layout::kChw, absl::MakeSpan(planes));
  for (size_t i = 0; i < count; ++i) {
    EXPECT_EQ(planes[i], pixels[i].red);
    EXPECT_EQ(planes[count + i], pixels[i].green);
    EXPECT_EQ(planes[2 * count + i], pixels[i].blue);
  }
}

TEST(FramePackingTest, GrayIsTheRoundedLumaInEitherLayout) {
  const std::vector<Rgba> pixels = ManyPixels();
  for (const Layout layout : {Layout::kHwc, Layout::kChw}) {
    std::vector<uint8_t> grey(pixels.size());
    PackFrame(pixels, Color::kGrayscale, layout, absl::MakeSpan(grey));
    for (size_t i = 0; i < pixels.size(); ++i) {
      const int luma = 77 * pixels[i].red + 150 * pixels[i].green + 29 * pixels[i].blue;
      EXPECT_EQ(grey[i], (luma + 128) / 256);
    }
    EXPECT_EQ(grey.front(), 0) << "black";
    EXPECT_EQ(grey.back(), 255) << "white";
  }
}

}  // namespace
}  // namespace procgen
