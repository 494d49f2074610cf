#ifndef ENVCORE_RENDER_RASTER_MIDPOINT_ELLIPSE_H_
#define ENVCORE_RENDER_RASTER_MIDPOINT_ELLIPSE_H_

#include "envcore/render/raster/runs.h"

namespace procgen {

// An ellipse that fills a rectangle of whole pixels, by the midpoint method.
struct MidpointEllipse {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// Emits its inside and its outline on a canvas of size_px x size_px, row by row as they are to be
// painted: in flat ellipses the inside of a later row covers the outline of an earlier one. The
// inside ends where the outline's runs begin, whether an outline is painted or not.
void EmitMidpointEllipse(const MidpointEllipse& ellipse, int size_px, RunSink inside,
                         RunSink outline);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_MIDPOINT_ELLIPSE_H_
