#ifndef ENVCORE_LEVEL_GENERATED_ART_H_
#define ENVCORE_LEVEL_GENERATED_ART_H_

#include <array>
#include <cstdint>
#include <vector>

#include "envcore/random/random_stream.h"

namespace procgen {

// Red, green, blue.
using Rgb = std::array<uint8_t, 3>;

// Art made from random numbers (use_generated_assets), as data: the painting steps, in order, on a
// canvas of size_px x size_px. No draw depends on what is painted, so drawing the numbers and
// painting the picture are apart: a level is generated here, render/ paints only what is looked at.
struct PaintStep {
  enum class Shape : uint8_t { kRectangle, kEllipse };
  Shape shape = Shape::kRectangle;
  double x = 0;  // pixels, y down
  double y = 0;
  double width = 0;
  double height = 0;
  Rgb fill = {0, 0, 0};
  Rgb outline = {0, 0, 0};  // ellipses only, 1 pixel wide, drawn over the filling
  // 255: replaces what is there, transparency included; below: laid over what is there.
  uint8_t alpha = 255;
};

struct GeneratedArt {
  int size_px = 0;
  bool transparent = false;  // where nothing is painted; a block paints its whole canvas
  std::vector<PaintStep> steps;
};

// A background of 500 x 500, drawn from the level stream.
GeneratedArt GenerateBackground(RandomStream& random);
// A block-shaped sprite of 64 x 64 that fills its canvas.
GeneratedArt GenerateBlock(RandomStream& random);
// A sprite of 64 x 64 made of crossing bars on a transparent ground.
GeneratedArt GenerateFigure(RandomStream& random);

}  // namespace procgen

#endif  // ENVCORE_LEVEL_GENERATED_ART_H_
