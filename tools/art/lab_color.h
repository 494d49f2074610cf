#ifndef TOOLS_ART_LAB_COLOR_H_
#define TOOLS_ART_LAB_COLOR_H_

#include <cmath>

#include "envcore/render/output/pixel.h"

namespace procgen {

// A color in CIELAB (white: D65): distances in it are about as large as they look.
struct LabColor {
  float lightness = 0;  // [0, 100]
  float a = 0;          // green to red
  float b = 0;          // blue to yellow
};

// The color of an sRGB pixel; its alpha is not looked at.
LabColor ToLab(const Rgba& pixel);

// How different two colors look (CIE76): about 2 can just be seen side by side, black and white
// are 100 apart.
inline float ColorDifference(const LabColor& first, const LabColor& second) {
  const float lightness = first.lightness - second.lightness;
  const float a = first.a - second.a;
  const float b = first.b - second.b;
  return std::sqrt(lightness * lightness + a * a + b * b);
}

}  // namespace procgen

#endif  // TOOLS_ART_LAB_COLOR_H_
