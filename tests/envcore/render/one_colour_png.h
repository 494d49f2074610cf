#ifndef TESTS_ENVCORE_RENDER_ONE_COLOUR_PNG_H_
#define TESTS_ENVCORE_RENDER_ONE_COLOUR_PNG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "envcore/render/output/pixel.h"
#include "gtest/gtest.h"
#include "png.h"

namespace procgen {

// A PNG file with these stored values, written by libpng. `pixels`: Rgba [height, width].
inline std::string PngOf(int width, int height, const std::vector<Rgba>& pixels) {
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

// A PNG file of this size with all pixels equal to the stored value `pixel`.
inline std::string OneColourPng(int width, int height, const Rgba& pixel) {
  return PngOf(width, height, std::vector<Rgba>(static_cast<size_t>(width * height), pixel));
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_RENDER_ONE_COLOUR_PNG_H_
