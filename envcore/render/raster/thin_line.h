#ifndef ENVCORE_RENDER_RASTER_THIN_LINE_H_
#define ENVCORE_RENDER_RASTER_THIN_LINE_H_

#include "absl/types/span.h"
#include "envcore/render/raster/curve.h"
#include "envcore/render/raster/runs.h"

namespace procgen {

// Emits the pixels of a straight line one pixel wide, both ends included, on a canvas of
// size_px x size_px.
void EmitLine(const Point& start, const Point& end, int size_px, RunSink sink);

// Emits the pixels of a closed outline one pixel wide, curve by curve. May emit a pixel twice.
void EmitOutline(absl::Span<const Curve> curves, int size_px, RunSink sink);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_THIN_LINE_H_
