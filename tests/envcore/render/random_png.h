#ifndef TESTS_ENVCORE_RENDER_RANDOM_PNG_H_
#define TESTS_ENVCORE_RENDER_RANDOM_PNG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "envcore/random/random_stream.h"
#include "envcore/render/output/pixel.h"
#include "tests/envcore/render/one_colour_png.h"

namespace procgen {

// A PNG file of this size, with random colors. `is_opaque`: else the alpha of
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
  return PngOf(width, height, pixels);
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_RENDER_RANDOM_PNG_H_
