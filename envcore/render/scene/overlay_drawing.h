#ifndef ENVCORE_RENDER_SCENE_OVERLAY_DRAWING_H_
#define ENVCORE_RENDER_SCENE_OVERLAY_DRAWING_H_

#include "envcore/render/output/frame.h"
#include "envcore/scene/camera.h"
#include "envcore/scene/scene.h"

namespace procgen {

// The rows that an overlay may touch, [top, bottom); may be outside the frame.
struct RowRange {
  int top = 0;
  int bottom = 0;
};
RowRange RowsOf(const Overlay& overlay, const Viewport& viewport);

// Draws a flat shape over the scene in the agent's view, without smoothing.
void DrawOverlayAliased(const Overlay& overlay, const Viewport& viewport, const Frame& frame);
// Draws a flat shape over the scene in the human view, pixels weighted by coverage.
void DrawOverlayAntialiased(const Overlay& overlay, const Viewport& viewport, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_OVERLAY_DRAWING_H_
