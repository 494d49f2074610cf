#ifndef TOOLS_ART_LAB_COLOR_H_
#define TOOLS_ART_LAB_COLOR_H_

#include <cmath>

#include "envcore/render/output/pixel.h"

namespace procgen {

// A color in CIELAB (white point D65). Distances approximate perceived differences.
struct LabColor {
  float lightness = 0;  // [0, 100]
  float a = 0;          // green to red
  float b = 0;          // blue to yellow
};

// Converts an sRGB pixel. Ignores alpha.
LabColor ToLab(const Rgba& pixel);

// The perceived difference of two colors (CIE76). About 2 is just visible side by side; black and
// white differ by 100.
inline float ColorDifference(const LabColor& first, const LabColor& second) {
  const float lightness = first.lightness - second.lightness;
  const float a = first.a - second.a;
  const float b = first.b - second.b;
  return std::sqrt(lightness * lightness + a * a + b * b);
}

}  // namespace procgen

#endif  // TOOLS_ART_LAB_COLOR_H_
