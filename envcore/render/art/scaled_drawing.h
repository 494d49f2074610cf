#ifndef ENVCORE_RENDER_ART_SCALED_DRAWING_H_
#define ENVCORE_RENDER_ART_SCALED_DRAWING_H_

#include <cstdint>

#include "envcore/render/art/scaled_image_cache.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/pixel_set.h"

namespace procgen {

// Draws a scaled image with its top left pixel at (left, top), which may be outside the frame.
// `opacity`: a factor for Mul; 255: opaque.
void DrawScaled(const ScaledImage& picture, int left, int top, uint32_t opacity,
                const Frame& frame);
// Copies the top left part of a scaled image into the pixels of `box`. `pixels`: the pixels to
// skip, updated with those done; null: draws all pixels. REQUIRES: the image is at least as large
// as `box`.
void DrawScaledBackdrop(const Image& image, const PixelBox& box, BackdropPixels* pixels,
                        const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_SCALED_DRAWING_H_
