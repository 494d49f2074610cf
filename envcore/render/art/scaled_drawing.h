#ifndef ENVCORE_RENDER_ART_SCALED_DRAWING_H_
#define ENVCORE_RENDER_ART_SCALED_DRAWING_H_

#include <cstdint>

#include "envcore/render/art/scaled_image_cache.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/pixel_set.h"

namespace procgen {

// Draws a picture that has its size, its top left pixel at (left, top), anywhere in the frame or
// outside. `opacity`: a factor of Mul, 255 for all.
void DrawScaled(const ScaledImage& picture, int left, int top, uint32_t opacity,
                const Frame& frame);
// Copies one into the pixels of `box`, from its top left pixel on. REQUIRES: it is at least as
// large. `pixels`: what may be left out and is done; null: all is drawn.
void DrawScaledBackdrop(const ScaledImage& picture, const PixelBox& box, BackdropPixels* pixels,
                        const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_SCALED_DRAWING_H_
