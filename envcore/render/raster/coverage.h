#ifndef ENVCORE_RENDER_RASTER_COVERAGE_H_
#define ENVCORE_RENDER_RASTER_COVERAGE_H_

#include <algorithm>
#include <cmath>

namespace procgen {

// The columns (or rows) that an interval touches, and how much of each it covers.
struct CoveredRange {
  double from = 0;  // the interval
  double to = 0;
  int first = 0;  // columns [first, end)
  int end = 0;

  // The covered fraction of column x, in [0, 1].
  double ShareOf(int x) const {
    const double left = std::max(from, static_cast<double>(x));
    const double right = std::min(to, static_cast<double>(x) + 1);
    return std::max(0.0, right - left);
  }
};

// The columns of [0, size_px) that the interval [start, start + size) touches. A negative size
// swaps its ends.
inline CoveredRange CoveredColumns(double start, double size, int size_px) {
  CoveredRange range;
  range.from = std::clamp(std::min(start, start + size), 0.0, static_cast<double>(size_px));
  range.to = std::clamp(std::max(start, start + size), 0.0, static_cast<double>(size_px));
  range.first = static_cast<int>(std::floor(range.from));
  range.end = static_cast<int>(std::ceil(range.to));
  return range;
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_COVERAGE_H_
