#ifndef ENVCORE_LEVEL_GENERATED_ART_H_
#define ENVCORE_LEVEL_GENERATED_ART_H_

#include <array>
#include <cstdint>
#include <vector>

#include "envcore/random/random_stream.h"

namespace procgen {

// Red, green, blue.
using Rgb = std::array<uint8_t, 3>;

// A painting step of generated art (use_generated_assets), on a canvas of size_px x size_px.
// Generated art is data: the numbers are drawn here, with the level, and painted in render/ only
// when the image is shown. No draw depends on what is painted.
struct PaintStep {
  enum class Shape : uint8_t { kRectangle, kEllipse };
  Shape shape = Shape::kRectangle;
  double x = 0;  // pixels, y down
  double y = 0;
  double width = 0;
  double height = 0;
  Rgb fill = {0, 0, 0};
  Rgb outline = {0, 0, 0};  // ellipses only; 1 pixel wide, drawn over the fill
  // 255: replaces the pixels, transparency included. Below 255: blended over them.
  uint8_t alpha = 255;
};

struct GeneratedArt {
  int size_px = 0;
  bool transparent = false;  // outside of the painted shapes; a block paints its whole canvas
  std::vector<PaintStep> steps;
};

// A background of 500 x 500 pixels, drawn from the level's stream.
GeneratedArt GenerateBackground(RandomStream& random);
// A block-shaped sprite of 64 x 64 pixels that fills its canvas.
GeneratedArt GenerateBlock(RandomStream& random);
// A sprite of 64 x 64 pixels: crossing bars on a transparent background.
GeneratedArt GenerateFigure(RandomStream& random);

}  // namespace procgen

#endif  // ENVCORE_LEVEL_GENERATED_ART_H_
