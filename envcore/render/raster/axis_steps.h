#ifndef ENVCORE_RENDER_RASTER_AXIS_STEPS_H_
#define ENVCORE_RENDER_RASTER_AXIS_STEPS_H_

#include <cstdint>

namespace procgen {

// The source column (or row) of each pixel column of a stretched image: pixel first + i shows
// (position + i * step) >> 16, for i in [0, count).
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

// The rule for the first position: fully opaque sprites use the truncated step, all others the
// exact step.
enum class FirstPosition { kTruncatedStep, kExactStep };

// For an image of `source_size` stretched over [start, start + size), on a canvas of size_px.
AxisSteps StretchedSteps(double start, double size, int source_size, int size_px,
                         FirstPosition first_position);
// For a half turn: the reversed image covers [start, start + size).
AxisSteps ReversedSteps(double start, double size, int source_size, int size_px,
                        FirstPosition first_position);
// For an image drawn at exactly its own size, copied one to one. Empty if it starts beyond the near
// edge of the last pixel.
AxisSteps CopiedSteps(double start, int source_size, int size_px);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_AXIS_STEPS_H_
