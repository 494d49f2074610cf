#ifndef ENVCORE_RENDER_RASTER_POLYGON_H_
#define ENVCORE_RENDER_RASTER_POLYGON_H_

#include "absl/types/span.h"
#include "envcore/render/raster/curve.h"
#include "envcore/render/raster/runs.h"

namespace procgen {

// Emits the pixels of a canvas of size_px x size_px whose centers are inside the closed outline of
// `curves`. REQUIRES: the outline is convex.
void EmitInside(absl::Span<const Curve> curves, int size_px, RunSink sink);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_POLYGON_H_
