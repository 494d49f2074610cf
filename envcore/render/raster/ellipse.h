#ifndef ENVCORE_RENDER_RASTER_ELLIPSE_H_
#define ENVCORE_RENDER_RASTER_ELLIPSE_H_

#include "envcore/render/raster/runs.h"
#include "envcore/scene/camera.h"

namespace procgen {

// Emits the inside and the outline, one pixel wide, of the ellipse in `rect` on a canvas of size_px
// x size_px, in painting order. A pixel may be emitted to both and more than once. Rectangles of
// whole pixels have their own rules (MidpointEllipse). Emits nothing if a size is not positive.
void EmitEllipse(const ScreenRect& rect, int size_px, RunSink inside, RunSink outline);
// Emits the inside of an ellipse without an outline.
void EmitEllipseInside(const ScreenRect& rect, int size_px, RunSink inside);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_ELLIPSE_H_
