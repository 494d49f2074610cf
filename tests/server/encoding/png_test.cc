#include "server/encoding/png.h"

#include <cstdint>
#include <random>
#include <vector>

#include "envcore/render/art/png_decoding.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

std::vector<uint8_t> NoiseImage(int32_t size_px) {
  std::minstd_rand random(3);
  std::vector<uint8_t> pixels(static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3);
  for (uint8_t& value : pixels) {
    value = static_cast<uint8_t>(random() >> 8);
  }
  return pixels;
}

TEST(PngTest, PixelsRoundTrip) {
  const std::vector<uint8_t> pixels = NoiseImage(31);
  const auto image = DecodePng(PngOf(pixels, 31), AlphaUse::kIgnored);
  ASSERT_THAT(image, IsOk());
  ASSERT_EQ(image->width(), 31);
  ASSERT_EQ(image->height(), 31);
  for (int y = 0; y < 31; ++y) {
    for (int x = 0; x < 31; ++x) {
      const uint8_t* pixel = &pixels[(static_cast<size_t>(y) * 31 + static_cast<size_t>(x)) * 3];
      ASSERT_EQ(image->At(x, y), (Rgba{pixel[0], pixel[1], pixel[2], 255})) << x << " " << y;
    }
  }
}

TEST(PngTest, IncompressibleImagesStayWithinTheBound) {
  for (const int32_t size_px : {16, 64, 511}) {
    EXPECT_LE(static_cast<int64_t>(PngOf(NoiseImage(size_px), size_px).size()),
              PngBytesMax(size_px));
  }
}

}  // namespace
}  // namespace procgen
