#ifndef TESTS_ENVCORE_RENDER_RANDOM_PNG_H_
#define TESTS_ENVCORE_RENDER_RANDOM_PNG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "envcore/random/random_stream.h"
#include "envcore/render/output/pixel.h"
#include "gtest/gtest.h"
#include "png.h"

namespace procgen {

// A PNG file of this size, written by libpng, with random colors. `is_opaque`: else the alpha of
// each pixel is 0, 255 or between.
inline std::string RandomPng(int width, int height, bool is_opaque, int64_t seed) {
  RandomStream random(seed);
  std::vector<Rgba> pixels(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (Rgba& pixel : pixels) {
    const auto byte = [&random] { return static_cast<uint8_t>(random.Int(256)); };
    const uint8_t alphas[] = {0, 255, byte()};
    pixel = {byte(), byte(), byte(),
             is_opaque ? uint8_t{255} : alphas[static_cast<size_t>(random.Int(3))]};
  }
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr), 0);
  std::string bytes(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr),
            0);
  return bytes;
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_RENDER_RANDOM_PNG_H_
