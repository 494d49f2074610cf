#include "envcore/render/raster/axis_steps.h"

#include <algorithm>
#include <cmath>

#include "envcore/render/output/pixel.h"

namespace procgen {
namespace {

constexpr double kOne = 65536;  // 16.16 fixed point

double StepScale(double exact, FirstPosition first_position) {
  return first_position == FirstPosition::kTruncatedStep ? std::trunc(exact) : exact;
}

// Drops the far columns that would show no source pixel (at most one, except for sizes near 0).
void KeepWithinSource(int source_size, AxisSteps& steps) {
  const int64_t limit = static_cast<int64_t>(source_size) * 65536 - 1;
  steps.position = std::clamp<int64_t>(steps.position, 0, limit);
  while (steps.count > 0) {
    const int64_t last = steps.position + steps.step * (steps.count - 1);
    if (last >= 0 && last <= limit) {
      return;
    }
    --steps.count;
  }
}

}  // namespace

AxisSteps StretchedSteps(double start, double size, int source_size, int size_px,
                         FirstPosition first_position) {
  AxisSteps steps;
  if (!(size > 0)) {
    return steps;
  }
  steps.first = std::max(0, RoundPx(start));
  steps.count = std::min(size_px, RoundPx(start + size)) - steps.first;
  if (steps.count <= 0) {
    steps.count = 0;
    return steps;
  }
  const double exact = kOne * (static_cast<double>(source_size) / size);
  steps.step = static_cast<int64_t>(exact);
  const double scale = StepScale(exact, first_position);
  steps.position = static_cast<int64_t>(std::ceil((steps.first + 0.5 - start) * scale)) - 1;
  KeepWithinSource(source_size, steps);
  return steps;
}

AxisSteps ReversedSteps(double start, double size, int source_size, int size_px,
                        FirstPosition first_position) {
  AxisSteps steps;
  if (!(size > 0)) {
    return steps;
  }
  steps.first = std::max(0, RoundPx(start));
  steps.count = std::min(size_px, RoundPx(start + size)) - steps.first;
  if (steps.count <= 0) {
    steps.count = 0;
    return steps;
  }
  const double exact = kOne * (static_cast<double>(source_size) / -size);
  steps.step = static_cast<int64_t>(exact);
  const double scale = StepScale(exact, first_position);
  steps.position = static_cast<int64_t>(source_size) * 65536 +
                   static_cast<int64_t>(std::floor((steps.first + 0.5 - start) * scale)) + 1;
  if ((steps.position >> 16) >= source_size) {
    steps.position += steps.step;
    --steps.count;
  }
  KeepWithinSource(source_size, steps);
  return steps;
}

AxisSteps CopiedSteps(double start, int source_size, int size_px) {
  AxisSteps steps;
  if (start > size_px - 1) {  // even if it rounds down to the last pixel
    return steps;
  }
  const int from = RoundPx(start);
  steps.first = std::max(0, from);
  steps.count = std::max(0, std::min(size_px, from + source_size) - steps.first);
  steps.position = static_cast<int64_t>(steps.first - from) * 65536;
  steps.step = 65536;
  return steps;
}

}  // namespace procgen
