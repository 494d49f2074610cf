#ifndef ENVCORE_RENDER_RASTER_FLAT_RECTANGLE_H_
#define ENVCORE_RENDER_RASTER_FLAT_RECTANGLE_H_

#include "envcore/render/output/frame.h"
#include "envcore/render/output/pixel.h"
#include "envcore/scene/camera.h"

namespace procgen {

// The pixels of a canvas whose centre a flat rectangle covers: edges rounded to the next pixel
// border, a negative size swaps them.
PixelBox CoveredPixels(const ScreenRect& rect, int width, int height);

// A translucent flat colour, premultiplied by the rule for flat colours (pictures have another).
Rgba PremultipliedFlat(const Rgba& plain);

// Draws a rectangle of `plain` (not premultiplied), without smoothing.
void DrawFlatAliased(const ScreenRect& rect, const Rgba& plain, const Frame& frame);

// Fills the part of `box` that is in the frame with an opaque colour.
void FillPixels(const PixelBox& box, const Rgba& color, const Frame& frame);

// Draws it with each pixel weighted by the part of it that is covered.
void DrawFlatAntialiased(const ScreenRect& rect, const Rgba& plain, const Frame& frame);

// The flat colour of an image kind's theme (use_monochrome_assets), opaque.
Rgba MonochromeColor(int kind, int theme);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_FLAT_RECTANGLE_H_
