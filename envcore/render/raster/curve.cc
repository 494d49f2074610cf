#include "envcore/render/raster/curve.h"

namespace procgen {
namespace {

constexpr double kControlShare = 0.5522847498;  // fraction of the half-axes

Point Middle(const Point& a, const Point& b) { return {(a.x + b.x) * 0.5, (a.y + b.y) * 0.5}; }

}  // namespace

CurveHalves Halve(const Curve& curve) {
  const Point inner = Middle(curve.p[1], curve.p[2]);
  const Point first_1 = Middle(curve.p[0], curve.p[1]);
  const Point second_2 = Middle(curve.p[2], curve.p[3]);
  const Point first_2 = Middle(first_1, inner);
  const Point second_1 = Middle(second_2, inner);
  const Point joint = Middle(first_2, second_1);
  return {{{curve.p[0], first_1, first_2, joint}}, {{joint, second_1, second_2, curve.p[3]}}};
}

std::array<Curve, 4> EllipseCurves(const ScreenRect& rect) {
  const double half_w = rect.width / 2;
  const double half_h = rect.height / 2;
  const double control_w = half_w * kControlShare;
  const double control_h = half_h * kControlShare;
  const double left = rect.x;
  const double top = rect.y;
  const double right = rect.x + rect.width;
  const double bottom = rect.y + rect.height;
  const double x = rect.x + half_w;
  const double y = rect.y + half_h;
  return {{
      {{{{right, y}, {right, y + control_h}, {x + control_w, bottom}, {x, bottom}}}},
      {{{{x, bottom}, {x - control_w, bottom}, {left, y + control_h}, {left, y}}}},
      {{{{left, y}, {left, y - control_h}, {x - control_w, top}, {x, top}}}},
      {{{{x, top}, {x + control_w, top}, {right, y - control_h}, {right, y}}}},
  }};
}

}  // namespace procgen
