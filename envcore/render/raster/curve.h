#ifndef ENVCORE_RENDER_RASTER_CURVE_H_
#define ENVCORE_RENDER_RASTER_CURVE_H_

#include <array>

#include "envcore/scene/camera.h"

namespace procgen {

struct Point {
  double x = 0;
  double y = 0;

  bool operator==(const Point&) const = default;
};

// A cubic Bezier curve from p[0] to p[3].
struct Curve {
  std::array<Point, 4> p;
};

// The two halves of a curve, in its direction.
struct CurveHalves {
  Curve first;
  Curve second;
};

CurveHalves Halve(const Curve& curve);

// The ellipse in `rect` as four curves: right, bottom, left, top, and back to the right.
std::array<Curve, 4> EllipseCurves(const ScreenRect& rect);

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_CURVE_H_
