#ifndef ENVCORE_RENDER_RASTER_AXIS_STEPS_H_
#define ENVCORE_RENDER_RASTER_AXIS_STEPS_H_

#include <cstdint>

namespace procgen {

// Which source column (or row) each pixel column of a stretched picture shows: pixel first + i
// shows (position + i * step) >> 16, for i in [0, count).
struct AxisSteps {
  // The source column of a pixel column. REQUIRES: first <= pixel < first + count.
  int SourceAt(int pixel) const {
    return static_cast<int>((position + (pixel - first) * step) >> 16);
  }

  int first = 0;
  int count = 0;
  int64_t position = 0;
  int64_t step = 0;
};

// How the first position is found: sprites at full opacity take the truncated step, all else the
// step itself.
enum class FirstPosition { kTruncatedStep, kExactStep };

// A picture of `source_size` stretched over [start, start + size), on a canvas of size_px.
AxisSteps StretchedSteps(double start, double size, int source_size, int size_px,
                         FirstPosition first_position);
// The same for a half turn: [start, start + size) is where the reversed picture stands.
AxisSteps ReversedSteps(double start, double size, int source_size, int size_px,
                        FirstPosition first_position);
// A picture of exactly the size drawn, copied one to one; nothing if it starts beyond the last
// pixel's near edge.
AxisSteps CopiedSteps(double start, int source_size, int size_px);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_AXIS_STEPS_H_
