#ifndef TESTS_ENVCORE_RENDER_ONE_COLOUR_PNG_H_
#define TESTS_ENVCORE_RENDER_ONE_COLOUR_PNG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "envcore/render/output/pixel.h"
#include "gtest/gtest.h"
#include "png.h"

namespace procgen {

// A PNG file of this size, written by libpng, with all pixels equal to the stored value `pixel`.
inline std::string OneColourPng(int width, int height, const Rgba& pixel) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGBA;
  const std::vector<Rgba> pixels(static_cast<size_t>(width) * static_cast<size_t>(height), pixel);
  png_alloc_size_t size = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr), 0);
  std::string bytes(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr),
            0);
  return bytes;
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_RENDER_ONE_COLOUR_PNG_H_
