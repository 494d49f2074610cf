#ifndef ENVCORE_RENDER_MIDPOINT_ELLIPSE_H_
#define ENVCORE_RENDER_MIDPOINT_ELLIPSE_H_

#include "envcore/render/runs.h"

namespace procgen {

// An ellipse that fills a rectangle of whole pixels, by the midpoint method.
struct MidpointEllipse {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// Its inside, which ends where the outline's runs begin whether an outline is drawn or not, on a
// canvas of side_px x side_px.
void EmitInside(const MidpointEllipse& ellipse, int side_px, RunSink sink);
// Its outline.
void EmitOutline(const MidpointEllipse& ellipse, int side_px, RunSink sink);

}  // namespace procgen

#endif  // ENVCORE_RENDER_MIDPOINT_ELLIPSE_H_
