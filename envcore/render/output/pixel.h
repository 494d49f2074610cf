#ifndef ENVCORE_RENDER_OUTPUT_PIXEL_H_
#define ENVCORE_RENDER_OUTPUT_PIXEL_H_

#include <bit>
#include <cmath>
#include <cstdint>

namespace procgen {

// A pixel with premultiplied alpha: no color channel is above alpha.
struct Rgba {
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  uint8_t alpha = 0;

  bool operator==(const Rgba&) const = default;
};

// c * a / 255, with the rounding that all drawing uses; exact for a = 0 and a = 255.
constexpr uint8_t Mul(uint32_t c, uint32_t a) {
  const uint32_t t = c * a;
  return static_cast<uint8_t>((t + (t >> 8) + 128) >> 8);
}

// Mul for all four channels, two at a time.
constexpr Rgba Mul(const Rgba& p, uint32_t a) {
  constexpr uint32_t kOdd = 0x00ff00ff;
  const auto bits = std::bit_cast<uint32_t>(p);
  const auto mul = [a](uint32_t pair) {
    const uint32_t t = pair * a;
    return ((t + ((t >> 8) & kOdd) + 0x00800080) >> 8) & kOdd;
  };
  return std::bit_cast<Rgba>(mul(bits & kOdd) | mul((bits >> 8) & kOdd) << 8);
}

// Premultiplies a color of an art file.
constexpr Rgba Premultiplied(const Rgba& p) {
  return {Mul(p.red, p.alpha), Mul(p.green, p.alpha), Mul(p.blue, p.alpha), p.alpha};
}

// Blends `source` over `below`. No channel overflows, because none is above its alpha.
constexpr void BlendOver(const Rgba& source, Rgba& below) {
  below = std::bit_cast<Rgba>(std::bit_cast<uint32_t>(source) +
                              std::bit_cast<uint32_t>(Mul(below, 255U - source.alpha)));
}

// Positions beyond this are clamped, so that they fit into an int. Pixels.
inline constexpr double kFarPx = 1e9;

// Rounds a position to a whole pixel: halves round up, also below zero. Far positions are clamped.
inline int RoundPx(double v) {
  const double half_up = v + 0.5;
  if (!(half_up > -kFarPx)) {
    return static_cast<int>(-kFarPx);
  }
  if (!(half_up < kFarPx)) {
    return static_cast<int>(kFarPx);
  }
  const int cut = static_cast<int>(half_up);  // towards 0
  return cut - (half_up < cut ? 1 : 0);
}

// Converts `opacity` in [0, 1] to a factor for Mul: 255 if fully opaque, else in 256 steps.
inline uint32_t OpacityFactor(float opacity) {
  if (!(opacity > 0)) {
    return 0;
  }
  if (opacity >= 1) {
    return 255;
  }
  const auto steps = static_cast<uint32_t>(static_cast<double>(opacity) * 256.0);
  return (255U * steps) >> 8;
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_OUTPUT_PIXEL_H_
