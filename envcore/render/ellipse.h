#ifndef ENVCORE_RENDER_ELLIPSE_H_
#define ENVCORE_RENDER_ELLIPSE_H_

#include "envcore/render/runs.h"
#include "envcore/scene/camera.h"

namespace procgen {

// Emits the inside of the ellipse in `rect` on a canvas of side_px x side_px. Rectangles of whole
// pixels follow rules of their own (MidpointEllipse). A size that is not positive: nothing.
void EmitEllipseInside(const ScreenRect& rect, int side_px, RunSink sink);
// Emits its outline, one pixel wide; a pixel may be emitted twice.
void EmitEllipseOutline(const ScreenRect& rect, int side_px, RunSink sink);

}  // namespace procgen

#endif  // ENVCORE_RENDER_ELLIPSE_H_
