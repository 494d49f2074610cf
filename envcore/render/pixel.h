#ifndef ENVCORE_RENDER_PIXEL_H_
#define ENVCORE_RENDER_PIXEL_H_

#include <cmath>
#include <cstdint>

namespace procgen {

// A pixel with premultiplied alpha: no colour channel is above the alpha.
struct Rgba {
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  uint8_t alpha = 0;

  bool operator==(const Rgba&) const = default;
};

// c * a / 255 as all drawing rounds it; exact for a = 0 and a = 255.
constexpr uint8_t Mul(uint32_t c, uint32_t a) {
  const uint32_t t = c * a;
  return static_cast<uint8_t>((t + (t >> 8) + 128) >> 8);
}

constexpr Rgba Mul(const Rgba& p, uint32_t a) {
  return {Mul(p.red, a), Mul(p.green, a), Mul(p.blue, a), Mul(p.alpha, a)};
}

// A plain colour of an art file, premultiplied.
constexpr Rgba Premultiplied(const Rgba& p) {
  return {Mul(p.red, p.alpha), Mul(p.green, p.alpha), Mul(p.blue, p.alpha), p.alpha};
}

// Lays `source` over the opaque pixel red, green, blue at `rgb`.
inline void LayOver(const Rgba& source, uint8_t* rgb) {
  const uint32_t rest = 255U - source.alpha;
  rgb[0] = static_cast<uint8_t>(source.red + Mul(rgb[0], rest));
  rgb[1] = static_cast<uint8_t>(source.green + Mul(rgb[1], rest));
  rgb[2] = static_cast<uint8_t>(source.blue + Mul(rgb[2], rest));
}

// Where places are cut to what an int holds, pixels.
inline constexpr double kFarPx = 1e9;

// The whole pixel next to a place: halves go up, also below zero. Far places are cut.
inline int RoundPx(double v) {
  const double rounded = std::floor(v + 0.5);
  if (!(rounded > -kFarPx)) {
    return static_cast<int>(-kFarPx);
  }
  return static_cast<int>(rounded < kFarPx ? rounded : kFarPx);
}

// `opacity` in [0, 1] as the factor of Mul: 255 for what is fully opaque, otherwise of 256 steps.
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

#endif  // ENVCORE_RENDER_PIXEL_H_
