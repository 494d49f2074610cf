#ifndef ENVCORE_RENDER_ART_NEAREST_SAMPLING_H_
#define ENVCORE_RENDER_ART_NEAREST_SAMPLING_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/art/upright_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/pixel_set.h"
#include "envcore/scene/camera.h"

namespace procgen {

// Draws an image into a rectangle for the agent's view, without smoothing. `rotation`: radians
// around the rectangle's center. `opacity`: in [0, 1]. An image that scales() is drawn into the
// whole pixels that it covers, any other one pixel by pixel by the rules of Procgen 0.10.7.
void DrawNearest(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                 float opacity, const Frame& frame);
// Draws a sprite made from random numbers, which has other rounding rules.
void DrawNearestGenerated(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                          float opacity, const Frame& frame);
// Draws a background, upright and opaque. `pixels`: the pixels to skip, updated with those done;
// null: draws all pixels.
void DrawNearestBackdrop(const MipmappedImage& picture, const ScreenRect& rect,
                         BackdropMotion motion, BackdropPixels* pixels, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_NEAREST_SAMPLING_H_
