#ifndef ENVCORE_RENDER_RASTER_ROTATED_RUNS_H_
#define ENVCORE_RENDER_RASTER_ROTATED_RUNS_H_

#include "envcore/render/raster/rotated_rect.h"
#include "envcore/render/raster/runs.h"

namespace procgen {

// Emits the pixels of a rotated image that is at least 16 pixels wide and high on the screen.
void EmitLargeRotated(const RotatedRect& rotated, int size_px, RunSink sink);

// Emits the pixels of a thick line from `a` to `b`, `thickness` times as thick as it is long. Used
// for small rotated images, and for upright ones made from random numbers.
void EmitThickLine(Point a, Point b, double thickness, int size_px, RunSink sink);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_ROTATED_RUNS_H_
