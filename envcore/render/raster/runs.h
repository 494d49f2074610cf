#ifndef ENVCORE_RENDER_RASTER_RUNS_H_
#define ENVCORE_RENDER_RASTER_RUNS_H_

#include <algorithm>

#include "absl/functional/function_ref.h"

namespace procgen {

// Receives the pixels [first, end) of row `row`. Runs are never empty and never outside the canvas.
// A shape is a sequence of runs, so it can be painted on a frame or on an image.
using RunSink = absl::FunctionRef<void(int row, int first, int end)>;

// Emits the part of a run that is on a canvas of width x height.
inline void EmitClipped(int row, int first, int end, int width, int height, RunSink sink) {
  if (row < 0 || row >= height) {
    return;
  }
  const int from = std::max(first, 0);
  const int to = std::min(end, width);
  if (from < to) {
    sink(row, from, to);
  }
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_RUNS_H_
