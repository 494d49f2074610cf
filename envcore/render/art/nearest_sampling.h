#ifndef ENVCORE_RENDER_ART_NEAREST_SAMPLING_H_
#define ENVCORE_RENDER_ART_NEAREST_SAMPLING_H_

#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/raster/pixel_set.h"
#include "envcore/scene/camera.h"

namespace procgen {

// Draws a picture into a rectangle without smoothing, as the agent sees it: rotated by `rotation`
// radians around the rectangle's centre, with `opacity` in [0, 1]. One that scales is drawn into
// the whole pixels that it covers; one that does not, pixel by pixel by the rules of Procgen
// 0.10.7.
void DrawNearest(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                 float opacity, const Frame& frame);
// Draws a sprite made from random numbers, which follows other rules of rounding.
void DrawNearestGenerated(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                          float opacity, const Frame& frame);
// Draws a background, upright and opaque. `pixels`: what may be left out and is done; null: all is
// drawn.
void DrawNearestBackdrop(const MipmappedImage& picture, const ScreenRect& rect,
                         BackdropPixels* pixels, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_NEAREST_SAMPLING_H_
