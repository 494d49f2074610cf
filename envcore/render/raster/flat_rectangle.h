#ifndef ENVCORE_RENDER_RASTER_FLAT_RECTANGLE_H_
#define ENVCORE_RENDER_RASTER_FLAT_RECTANGLE_H_

#include "envcore/render/output/frame.h"
#include "envcore/render/output/pixel.h"
#include "envcore/scene/camera.h"

namespace procgen {

// The pixels whose centers a flat rectangle covers: edges are rounded to the nearest pixel border,
// and a negative size swaps them.
PixelBox CoveredPixels(const ScreenRect& rect, int width, int height);

// Premultiplies a translucent flat color. Flat colors round differently from images.
Rgba PremultipliedFlat(const Rgba& plain);

// Draws a rectangle in `plain` (not premultiplied), without smoothing.
void DrawFlatAliased(const ScreenRect& rect, const Rgba& plain, const Frame& frame);

// Fills the part of `box` inside the frame with an opaque color.
void FillPixels(const PixelBox& box, const Rgba& color, const Frame& frame);

// Draws a rectangle in `plain`, each pixel weighted by its covered fraction.
void DrawFlatAntialiased(const ScreenRect& rect, const Rgba& plain, const Frame& frame);

// The flat color of a kind and theme (use_monochrome_assets), opaque.
Rgba MonochromeColor(int kind, int theme);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_FLAT_RECTANGLE_H_
