#ifndef ENVCORE_RENDER_ART_UPRIGHT_IMAGE_H_
#define ENVCORE_RENDER_ART_UPRIGHT_IMAGE_H_

#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/image.h"
#include "envcore/render/raster/pixel_set.h"
#include "envcore/render/raster/rotated_rect.h"

namespace procgen {

// Draws `image` stretched into `rect`; each pixel shows one source pixel. `opaque`: whether all
// pixels of the image are opaque. `opacity`: a factor for Mul.
void DrawUpright(const Image& image, bool opaque, uint32_t opacity, const ScreenRect& rect,
                 const Frame& frame);
// Draws `image` upside down. REQUIRES: rotated.IsHalfTurn().
void DrawHalfTurn(const Image& image, bool opaque, uint32_t opacity, const RotatedRect& rotated,
                  const Frame& frame);
// Draws a background; its colors are copied unchanged. `pixels`: the pixels to skip, updated with
// those done; null: draws all pixels.
void DrawBackdrop(const Image& image, const ScreenRect& rect, BackdropPixels* pixels,
                  const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_UPRIGHT_IMAGE_H_
