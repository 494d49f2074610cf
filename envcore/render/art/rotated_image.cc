#include "envcore/render/art/rotated_image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "envcore/render/raster/rotated_runs.h"

namespace procgen {
namespace {

constexpr double kOne = 65536;       // 16.16 fixed point
constexpr double kNudge = 1 / kOne;  // source pixels; makes borders fall to one side
constexpr double kFarFixed = 1e15;

int64_t ToFixed(double v) { return static_cast<int64_t>(std::clamp(v, -kFarFixed, kFarFixed)); }

// A position in the source, in 16.16 pixels, and its change from one pixel to the next on the
// right.
struct SourceWalk {
  int64_t column = 0;
  int64_t row = 0;
  int64_t column_step = 0;
  int64_t row_step = 0;
};

// Draws the pixels [first, end) of a row; source positions are clamped to the image.
void DrawRun(const Image& image, uint32_t opacity, SourceWalk walk, int row, int first, int end,
             const Frame& frame) {
  Rgba* pixel = frame.At(first, row);
  const int64_t last_column = image.width() - 1;
  const int64_t last_row = image.height() - 1;
  for (int x = first; x < end; ++x, ++pixel) {
    const int64_t source_row = std::clamp<int64_t>(walk.row >> 16, 0, last_row);
    const int64_t source_column = std::clamp<int64_t>(walk.column >> 16, 0, last_column);
    const Rgba& source = image.At(static_cast<int>(source_column), static_cast<int>(source_row));
    if (source.alpha != 0) {
      BlendOver(Mul(source, opacity), *pixel);
    }
    walk.column += walk.column_step;
    walk.row += walk.row_step;
  }
}

// Maps screen to source: column = xx * x + xy * y + x0, row = yx * x + yy * y + y0.
struct SourceMap {
  double xx = 0;
  double xy = 0;
  double x0 = 0;
  double yx = 0;
  double yy = 0;
  double y0 = 0;
};

// The map of large images, from the positions of three corners.
SourceMap MapFromCorners(const Image& image, const RotatedRect& rotated) {
  const std::array<Point, 4> places = rotated.Corners();
  const double w = image.width();
  const double h = image.height();
  const std::array<Point, 4> sources = {{{0, 0}, {w, 0}, {w, h}, {0, h}}};
  size_t top = 0;
  for (size_t i = 1; i < places.size(); ++i) {
    if (places[i].y < places[top].y) {
      top = i;
    }
  }
  size_t left = (top + 1) % 4;
  const size_t bottom = (top + 2) % 4;
  const size_t right = (top + 3) % 4;
  const auto offset = [](const Point& from, const Point& to) {
    return Point{to.x - from.x, to.y - from.y};
  };
  const Point next = offset(places[top], places[left]);
  const Point previous = offset(places[top], places[right]);
  if (next.x * previous.y - next.y * previous.x > 0) {
    left = right;
  }
  const Point p = offset(places[top], places[left]);
  const Point q = offset(places[top], places[bottom]);
  const Point p_source = offset(sources[top], sources[left]);
  const Point q_source = offset(sources[top], sources[bottom]);
  const double e = 1 / (p.x * q.y - p.y * q.x);
  SourceMap map;
  map.xx = (p_source.x * q.y - p.y * q_source.x) * e;
  map.xy = (p.x * q_source.x - p_source.x * q.x) * e;
  map.x0 = sources[top].x - map.xx * places[top].x - map.xy * places[top].y;
  map.yx = (p_source.y * q.y - p.y * q_source.y) * e;
  map.yy = (p.x * q_source.y - p_source.y * q.x) * e;
  map.y0 = sources[top].y - map.yx * places[top].x - map.yy * places[top].y;
  return map;
}

// The map of small images: the inverse of the map from source to screen.
SourceMap InvertedMap(const Image& image, const RotatedRect& rotated) {
  const ScreenRect& rect = rotated.unrotated();
  const double scale_x = rect.width / image.width();
  const double scale_y = rect.height / image.height();
  SourceMap map;
  if (rotated.IsUpright()) {
    const double offset_x = kNudge * scale_x + rect.x;
    const double offset_y = kNudge * scale_y + rect.y;
    map.xx = 1 / scale_x;
    map.yy = 1 / scale_y;
    map.x0 = -offset_x * map.xx;
    map.y0 = -offset_y * map.yy;
    return map;
  }
  const Point corner = rotated.Map(-rect.width / 2, -rect.height / 2);
  // Source to screen: x = m11 * column + m21 * row + dx, y = m12 * column + m22 * row + dy.
  const double m11 = rotated.cos() * scale_x;
  const double m12 = rotated.sin() * scale_x;
  const double m21 = -rotated.sin() * scale_y;
  const double m22 = rotated.cos() * scale_y;
  const double dx = kNudge * m11 + kNudge * m21 + corner.x;
  const double dy = kNudge * m12 + kNudge * m22 + corner.y;
  const double inverse = 1 / (m11 * m22 - m12 * m21);
  map.xx = m22 * inverse;
  map.yx = -m12 * inverse;
  map.xy = -m21 * inverse;
  map.yy = m11 * inverse;
  map.x0 = (m21 * dy - m22 * dx) * inverse;
  map.y0 = (m12 * dx - m11 * dy) * inverse;
  return map;
}

// Small images: the position of the first pixel of a run is computed, the others follow by steps.
void DrawMappedRun(const Image& image, uint32_t opacity, const SourceMap& map, int row, int first,
                   int end, const Frame& frame) {
  const double x = first + 0.5;
  const double y = row + 0.5;
  const SourceWalk walk = {ToFixed((map.xy * y + map.xx * x + map.x0) * kOne),
                           ToFixed((map.yy * y + map.yx * x + map.y0) * kOne),
                           ToFixed(map.xx * kOne), ToFixed(map.yx * kOne)};
  DrawRun(image, opacity, walk, row, first, end, frame);
}

bool IsEmpty(const ScreenRect& rect) { return !(rect.width > 0) || !(rect.height > 0); }

}  // namespace

void DrawLargeRotated(const Image& image, uint32_t opacity, const RotatedRect& rotated,
                      const Frame& frame) {
  const SourceMap map = MapFromCorners(image, rotated);
  const int64_t xx = ToFixed(map.xx * kOne);
  const int64_t xy = ToFixed(map.xy * kOne);
  const int64_t yx = ToFixed(map.yx * kOne);
  const int64_t yy = ToFixed(map.yy * kOne);
  const int64_t x0 = ToFixed(std::ceil((0.5 * map.xx + 0.5 * map.xy + map.x0) * kOne)) - 1;
  const int64_t y0 = ToFixed(std::ceil((0.5 * map.yx + 0.5 * map.yy + map.y0) * kOne)) - 1;
  EmitLargeRotated(rotated, frame.size_px, [&](int row, int first, int end) {
    const SourceWalk walk = {first * xx + row * xy + x0, first * yx + row * yy + y0, xx, yx};
    DrawRun(image, opacity, walk, row, first, end, frame);
  });
}

void DrawSmallRotated(const Image& image, uint32_t opacity, const RotatedRect& rotated,
                      const Frame& frame) {
  const ScreenRect& rect = rotated.unrotated();
  if (IsEmpty(rect)) {
    return;
  }
  const SourceMap map = InvertedMap(image, rotated);
  const double left = -rect.width / 2;
  EmitThickLine(rotated.Map(left, 0), rotated.Map(left + rect.width, 0), rect.height / rect.width,
                frame.size_px, [&](int row, int first, int end) {
                  DrawMappedRun(image, opacity, map, row, first, end, frame);
                });
}

void DrawGenerated(const Image& image, uint32_t opacity, const RotatedRect& rotated,
                   const Frame& frame) {
  const ScreenRect& rect = rotated.unrotated();
  if (IsEmpty(rect)) {
    return;
  }
  if (!rotated.IsUpright() && !rotated.IsHalfTurn()) {
    DrawSmallRotated(image, opacity, rotated, frame);
    return;
  }
  const SourceMap map = InvertedMap(image, rotated);
  const auto draw_run = [&](int row, int first, int end) {
    DrawMappedRun(image, opacity, map, row, first, end, frame);
  };
  if (rotated.IsHalfTurn()) {
    const std::array<Point, 4> corners = rotated.Corners();
    for (int row = RoundPx(corners[2].y); row < RoundPx(corners[0].y); ++row) {
      EmitClipped(row, RoundPx(corners[2].x), RoundPx(corners[0].x), frame.size_px, frame.size_px,
                  draw_run);
    }
    return;
  }
  const double middle = (rect.y + (rect.y + rect.height)) * 0.5;
  EmitThickLine({rect.x, middle}, {rect.x + rect.width, middle}, rect.height / rect.width,
                frame.size_px, draw_run);
}

}  // namespace procgen
