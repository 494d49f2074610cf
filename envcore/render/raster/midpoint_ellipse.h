#ifndef ENVCORE_RENDER_RASTER_MIDPOINT_ELLIPSE_H_
#define ENVCORE_RENDER_RASTER_MIDPOINT_ELLIPSE_H_

#include "envcore/render/raster/runs.h"

namespace procgen {

// An ellipse in a rectangle of whole pixels, drawn by the midpoint method.
struct MidpointEllipse {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// Emits inside and outline on a canvas of size_px x size_px, row by row in painting order: in flat
// ellipses the inside of a later row covers the outline of an earlier one. The inside ends where
// the runs of the outline begin, whether or not an outline is painted.
void EmitMidpointEllipse(const MidpointEllipse& ellipse, int size_px, RunSink inside,
                         RunSink outline);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_MIDPOINT_ELLIPSE_H_
