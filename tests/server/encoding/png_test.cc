#include "server/encoding/png.h"

#include <cstdint>
#include <random>
#include <vector>

#include "gtest/gtest.h"

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

TEST(PngTest, IncompressibleImagesStayWithinTheBound) {
  for (const int32_t size_px : {16, 64, 511}) {
    EXPECT_LE(static_cast<int64_t>(PngOf(NoiseImage(size_px), size_px).size()),
              PngBytesMax(size_px));
  }
}

}  // namespace
}  // namespace procgen
