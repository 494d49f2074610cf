#include "envcore/render/raster/rotated_runs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "envcore/render/output/pixel.h"

namespace procgen {
namespace {

constexpr double kOne = 65536;  // 16.16 fixed point
constexpr double kLevelSlope = 1e20;
constexpr double kFarFixed = 1e15;  // outside of any image

// Converts to 16.16, truncated. Far positions are clamped, but stay outside.
int64_t ToFixed(double v) {
  return static_cast<int64_t>(std::clamp(v * kOne, -kFarFixed, kFarFixed));
}

// The position of an edge in a row, and its slope.
struct Boundary {
  int64_t x = 0;
  int64_t step = 0;
};

// The edge from `upper` to `lower`, in row `row`.
Boundary EdgeAt(const Point& upper, const Point& lower, int row) {
  const double slope = (lower.x - upper.x) / (lower.y - upper.y);
  return {ToFixed(upper.x + (0.5 + row - upper.y) * slope + 0.5), ToFixed(slope)};
}

struct Edge {
  const Point& upper;
  const Point& lower;
};

// Emits the rows between the heights y1 and y2, from the left edge to the right edge.
void EmitBand(double y1, double y2, const Edge& left_edge, const Edge& right_edge, int size_px,
              RunSink sink) {
  const int first = std::max(0, RoundPx(y1));
  const int end = std::min(size_px, RoundPx(y2));
  if (first >= end) {
    return;
  }
  Boundary left = EdgeAt(left_edge.upper, left_edge.lower, first);
  Boundary right = EdgeAt(right_edge.upper, right_edge.lower, first);
  for (int row = first; row < end; ++row) {
    EmitClipped(row, static_cast<int>(left.x >> 16), static_cast<int>(right.x >> 16), size_px,
                size_px, sink);
    left.x += left.step;
    right.x += right.step;
  }
}

double Floor64th(double v) { return std::floor(v * 64) / 64; }

bool EqualIn64ths(double a, double b) { return static_cast<int64_t>((b - a) * 64) == 0; }

// The first row whose center is not above `y`. By the rule for thick lines this truncates below
// zero instead of rounding.
int FirstRowFrom(double y) {
  return static_cast<int>(y + 0.5);  // NOLINT(bugprone-incorrect-roundings)
}

// The last row that is completely above `y`, by the rule for thick lines.
int LastRowAbove(double y) { return y < 0.5 ? -1 : static_cast<int>(y - 0.5); }

struct ThickLine {
  Point a;
  Point b;
  double thickness = 0;
};

double SquaredLength(const ThickLine& line) {
  const double x = line.a.x - line.b.x;
  const double y = line.a.y - line.b.y;
  return x * x + y * y;
}

// Clips the line to the visible part. Returns false if nothing is left.
bool CutToCanvas(int size_px, ThickLine& line) {
  const double margin_x = std::abs(line.b.y - line.a.y) * line.thickness * 0.5;
  const double margin_y = std::abs(line.b.x - line.a.x) * line.thickness * 0.5;
  const std::array<double, 2> low = {-margin_x, -margin_y};
  const std::array<double, 2> high = {size_px + margin_x, size_px + margin_y};
  const auto inside = [&](const Point& p) {
    return p.x >= low[0] && p.x <= high[0] && p.y >= low[1] && p.y <= high[1];
  };
  const double old_length = SquaredLength(line);
  if (!inside(line.a) || !inside(line.b)) {
    const std::array<double, 2> origin = {line.a.x, line.a.y};
    const std::array<double, 2> delta = {line.b.x - line.a.x, line.b.y - line.a.y};
    double from = 0;
    double to = 1;
    for (size_t i = 0; i < 2; ++i) {
      if (delta[i] == 0) {
        if (origin[i] <= low[i] || origin[i] >= high[i]) {
          return false;
        }
        continue;
      }
      const double inverse = 1 / delta[i];
      double enters = (low[i] - origin[i]) * inverse;
      double leaves = (high[i] - origin[i]) * inverse;
      if (enters > leaves) {
        std::swap(enters, leaves);
      }
      from = std::max(from, enters);
      to = std::min(to, leaves);
      if (from >= to) {
        return false;
      }
    }
    line.a = {origin[0] + delta[0] * from, origin[1] + delta[1] * from};
    line.b = {origin[0] + delta[0] * to, origin[1] + delta[1] * to};
  }
  const double new_length = SquaredLength(line);
  if (!(new_length > 0)) {
    return false;
  }
  line.thickness *= std::sqrt(old_length / new_length);
  return true;
}

void EmitUprightLine(ThickLine line, int size_px, RunSink sink) {
  if (line.a.y > line.b.y) {
    std::swap(line.a, line.b);
  }
  const double half_width = 0.5 * line.thickness * (line.b.y - line.a.y);
  const double side = size_px;
  const double left = std::clamp(line.a.x - half_width, 0.0, side);
  const double right = std::clamp(line.a.x + half_width, 0.0, side);
  const double top = std::clamp(line.a.y, 0.0, side);
  const double bottom = std::clamp(line.b.y, 0.0, side);
  if (EqualIn64ths(left, right) || EqualIn64ths(top, bottom)) {
    return;
  }
  const int first = FirstRowFrom(left);
  const int last = LastRowAbove(right);
  for (int row = FirstRowFrom(top); row <= LastRowAbove(bottom); ++row) {
    EmitClipped(row, first, last + 1, size_px, size_px, sink);
  }
}

// The corners of a slanted line, each coordinate rounded down to 1/64.
struct SlantedCorners {
  Point top;
  Point left;
  Point right;
  Point bottom;
};

SlantedCorners CornersOf(const ThickLine& line) {
  const double half = 0.5 * line.thickness;
  const Point normal = {(line.b.y - line.a.y) * half, -((line.b.x - line.a.x) * half)};
  const auto corner = [&normal](const Point& p, double sign) {
    return Point{Floor64th(p.x + sign * normal.x), Floor64th(p.y + sign * normal.y)};
  };
  if (line.a.x < line.b.x) {
    return {corner(line.a, 1), corner(line.a, -1), corner(line.b, 1), corner(line.b, -1)};
  }
  return {corner(line.a, -1), corner(line.b, -1), corner(line.a, 1), corner(line.b, 1)};
}

double SlopeOf(const Point& upper, const Point& lower) {
  const double x = lower.x - upper.x;
  const double y = lower.y - upper.y;
  return y == 0 ? std::copysign(kLevelSlope, x) : x / y;
}

void EmitSlanted(ThickLine line, int size_px, RunSink sink) {
  if (line.a.y > line.b.y) {
    std::swap(line.a, line.b);
  }
  const SlantedCorners c = CornersOf(line);
  // Left edges are moved half a pixel to the right, right edges half a pixel to the left.
  const auto boundary = [](const Point& upper, const Point& lower, int row, double inset) {
    const double slope = SlopeOf(upper, lower);
    return Boundary{ToFixed(upper.x + inset + (row + 0.5 - upper.y) * slope), ToFixed(slope)};
  };
  const int first = FirstRowFrom(c.top.y);
  const int last = LastRowAbove(c.bottom.y);
  const int left_turn = LastRowAbove(c.left.y);
  const int right_turn = LastRowAbove(c.right.y);
  Boundary left = boundary(c.top, c.left, first, 0.5);
  Boundary right = boundary(c.top, c.right, first, -0.5);
  Boundary lower_left = boundary(c.left, c.bottom, left_turn + 1, 0.5);
  Boundary lower_right = boundary(c.right, c.bottom, right_turn + 1, -0.5);
  for (int row = first; row <= last; ++row) {
    Boundary& on_left = row > left_turn ? lower_left : left;
    Boundary& on_right = row > right_turn ? lower_right : right;
    EmitClipped(row, static_cast<int>(on_left.x >> 16), static_cast<int>(on_right.x >> 16) + 1,
                size_px, size_px, sink);
    on_left.x += on_left.step;
    on_right.x += on_right.step;
  }
}

}  // namespace

void EmitLargeRotated(const RotatedRect& rotated, int size_px, RunSink sink) {
  const std::array<Point, 4> corners = rotated.Corners();
  const auto top = static_cast<size_t>(
      std::min_element(corners.begin(), corners.end(),
                       [](const Point& p, const Point& q) { return p.y < q.y; }) -
      corners.begin());
  const Point& p0 = corners[top];
  Point p1 = corners[(top + 1) % 4];
  const Point& p2 = corners[(top + 2) % 4];
  Point p3 = corners[(top + 3) % 4];
  if ((p1.x - p0.x) * (p3.y - p0.y) - (p1.y - p0.y) * (p3.x - p0.x) > 0) {
    std::swap(p1, p3);
  }
  if (p1.y < p3.y) {
    EmitBand(p0.y, p1.y, {p0, p1}, {p0, p3}, size_px, sink);
    EmitBand(p1.y, p3.y, {p1, p2}, {p0, p3}, size_px, sink);
    EmitBand(p3.y, p2.y, {p1, p2}, {p3, p2}, size_px, sink);
  } else {
    EmitBand(p0.y, p3.y, {p0, p1}, {p0, p3}, size_px, sink);
    EmitBand(p3.y, p1.y, {p0, p1}, {p3, p2}, size_px, sink);
    EmitBand(p1.y, p2.y, {p1, p2}, {p3, p2}, size_px, sink);
  }
}

void EmitThickLine(Point a, Point b, double thickness, int size_px, RunSink sink) {
  if (a == b || !(thickness > 0)) {
    return;
  }
  ThickLine line = {a, b, thickness};
  if (!CutToCanvas(size_px, line)) {
    return;
  }
  if (EqualIn64ths(line.a.y, line.b.y)) {
    const double x = (line.a.x + line.b.x) * 0.5;
    const double half_length = line.thickness * (std::abs(line.b.x - line.a.x) * 0.5);
    line = {{x, line.a.y - half_length}, {x, line.a.y + half_length}, 1 / line.thickness};
  }
  if (EqualIn64ths(line.a.x, line.b.x)) {
    EmitUprightLine(line, size_px, sink);
  } else {
    EmitSlanted(line, size_px, sink);
  }
}

}  // namespace procgen
