#ifndef ENVCORE_RENDER_ART_TURNED_PICTURE_H_
#define ENVCORE_RENDER_ART_TURNED_PICTURE_H_

#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/image.h"
#include "envcore/render/raster/turn.h"

namespace procgen {

// Draws `image` stretched into the turned rectangle, each pixel showing one source pixel.
// `opacity`: a factor of Mul.

// A picture whose bounding box on the screen is at least 16 pixels wide and high.
void DrawLargeTurned(const Image& image, uint32_t opacity, const TurnedRect& turned,
                     const Frame& frame);
// A smaller one.
void DrawSmallTurned(const Image& image, uint32_t opacity, const TurnedRect& turned,
                     const Frame& frame);
// A sprite made from random numbers, turned or not, of any size.
void DrawGenerated(const Image& image, uint32_t opacity, const TurnedRect& turned,
                   const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_TURNED_PICTURE_H_
