#ifndef ENVCORE_RENDER_RASTER_TURNED_RUNS_H_
#define ENVCORE_RENDER_RASTER_TURNED_RUNS_H_

#include "envcore/render/raster/runs.h"
#include "envcore/render/raster/turn.h"

namespace procgen {

// Emits the pixels of a turned picture that is at least 16 pixels wide and high on the screen.
void EmitLargeTurned(const TurnedRect& turned, int side_px, RunSink sink);

// Emits the pixels of a thick line from `a` to `b`, `thickness` times as thick as it is long: a
// small turned picture, or an upright one made from random numbers.
void EmitThickLine(Point a, Point b, double thickness, int side_px, RunSink sink);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_TURNED_RUNS_H_
