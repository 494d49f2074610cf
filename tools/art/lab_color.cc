#include "tools/art/lab_color.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace procgen {
namespace {

// The linear intensity of each value of an sRGB channel.
std::array<float, 256> MakeIntensities() {
  std::array<float, 256> intensities = {};
  for (size_t value = 0; value < intensities.size(); ++value) {
    const float share = static_cast<float>(value) / 255;
    intensities[value] = share <= 0.04045F ? share / 12.92F  // linear near black
                                           : std::pow((share + 0.055F) / 1.055F, 2.4F);
  }
  return intensities;
}

// The perceived lightness of an intensity: a cube root that is linear near black.
float Perceived(float share) {
  constexpr float kStraightBelow = 216.0F / 24389;
  constexpr float kSlope = 24389.0F / 27;
  return share > kStraightBelow ? std::cbrt(share) : (kSlope * share + 16) / 116;
}

}  // namespace

LabColor ToLab(const Rgba& pixel) {
  static const std::array<float, 256> intensities = MakeIntensities();
  const float red = intensities[pixel.red];
  const float green = intensities[pixel.green];
  const float blue = intensities[pixel.blue];
  // sRGB to XYZ, relative to the white point.
  const float x = Perceived((0.4124F * red + 0.3576F * green + 0.1805F * blue) / 0.9505F);
  const float y = Perceived(0.2126F * red + 0.7152F * green + 0.0722F * blue);
  const float z = Perceived((0.0193F * red + 0.1192F * green + 0.9505F * blue) / 1.089F);
  return {.lightness = 116 * y - 16, .a = 500 * (x - y), .b = 200 * (y - z)};
}

}  // namespace procgen
