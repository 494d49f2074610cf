#ifndef ENVCORE_RENDER_ART_ROTATED_IMAGE_H_
#define ENVCORE_RENDER_ART_ROTATED_IMAGE_H_

#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/image.h"
#include "envcore/render/raster/rotated_rect.h"

namespace procgen {

// Draws `image` stretched into the rotated rectangle; each pixel shows one source pixel.
// `opacity`: a factor for Mul.

// For images whose bounding box on the screen is at least 16 pixels wide and high.
void DrawLargeRotated(const Image& image, uint32_t opacity, const RotatedRect& rotated,
                      const Frame& frame);
// For smaller images.
void DrawSmallRotated(const Image& image, uint32_t opacity, const RotatedRect& rotated,
                      const Frame& frame);
// For sprites made from random numbers, rotated or not, of any size.
void DrawGenerated(const Image& image, uint32_t opacity, const RotatedRect& rotated,
                   const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_ROTATED_IMAGE_H_
