#include "envcore/render/raster/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "absl/container/inlined_vector.h"
#include "envcore/render/output/pixel.h"

namespace procgen {
namespace {

constexpr double kFlatness = 0.25;  // pixels
constexpr int kHalvingsMax = 9;
constexpr int64_t kOne = 1 << 16;  // 16.16 fixed point
// Polygons with at most this many rows, the largest observation, need no allocation.
constexpr size_t kRowsInPlace = 512;

// A corner, in 1/64 of a pixel.
struct Corner {
  int64_t x = 0;
  int64_t y = 0;
};

// The columns at which the outline enters and leaves a row, in 16.16 pixels.
struct RowExtent {
  int64_t left = std::numeric_limits<int64_t>::max();
  int64_t right = std::numeric_limits<int64_t>::min();
};

Corner ToCorner(const Point& p) { return {RoundPx(p.x * 64), RoundPx(p.y * 64)}; }

bool IsFlat(const Curve& curve) {
  const Point& start = curve.p[0];
  const double chord_x = curve.p[3].x - start.x;
  const double chord_y = curve.p[3].y - start.y;
  double length = std::abs(chord_x) + std::abs(chord_y);
  double distance = 0;
  if (length > 1) {
    distance = std::abs(chord_x * (start.y - curve.p[1].y) - chord_y * (start.x - curve.p[1].x)) +
               std::abs(chord_x * (start.y - curve.p[2].y) - chord_y * (start.x - curve.p[2].x));
  } else {
    distance = std::abs(start.x - curve.p[1].x) + std::abs(start.y - curve.p[1].y) +
               std::abs(start.x - curve.p[2].x) + std::abs(start.y - curve.p[2].y);
    length = 1;
  }
  return distance < kFlatness * length;
}

class Polygon {
 public:
  explicit Polygon(int size_px) : size_px_(size_px), rows_(static_cast<size_t>(size_px)) {}

  void AddCurve(const Curve& curve, int halvings) {  // NOLINT(misc-no-recursion)
    if (halvings == 0 || IsFlat(curve)) {
      AddEdge(ToCorner(curve.p[0]), ToCorner(curve.p[3]));
      return;
    }
    const CurveHalves halves = Halve(curve);
    AddCurve(halves.first, halvings - 1);
    AddCurve(halves.second, halvings - 1);
  }

  void Emit(RunSink sink) const {
    for (int row = 0; row < size_px_; ++row) {
      const RowExtent& extent = rows_[static_cast<size_t>(row)];
      if (extent.left <= extent.right) {
        EmitClipped(row, static_cast<int>(extent.left >> 16), static_cast<int>(extent.right >> 16),
                    size_px_, size_px_, sink);
      }
    }
  }

 private:
  void AddEdge(Corner a, Corner b) {
    if (a.y > b.y) {
      std::swap(a, b);
    }
    const int64_t first = std::max<int64_t>(0, (a.y + 32) >> 6);
    const int64_t last = std::min<int64_t>(size_px_ - 1, (b.y - 32) >> 6);
    if (first > last) {
      return;
    }
    const double slope = static_cast<double>(b.x - a.x) / static_cast<double>(b.y - a.y);
    const auto step = static_cast<int64_t>(slope * static_cast<double>(kOne));
    int64_t x = a.x * (kOne / 64) + kOne / 2 +
                ((step * (first * kOne + kOne / 2 - a.y * (kOne / 64))) >> 16);
    for (int64_t row = first; row <= last; ++row) {
      const int64_t place = std::clamp<int64_t>(x, 0, size_px_ * kOne);
      RowExtent& extent = rows_[static_cast<size_t>(row)];
      extent.left = std::min(extent.left, place);
      extent.right = std::max(extent.right, place);
      x += step;
    }
  }

  int size_px_;
  absl::InlinedVector<RowExtent, kRowsInPlace> rows_;
};

}  // namespace

void EmitInside(absl::Span<const Curve> curves, int size_px, RunSink sink) {
  Polygon polygon(size_px);
  for (const Curve& curve : curves) {
    polygon.AddCurve(curve, kHalvingsMax);
  }
  polygon.Emit(sink);
}

}  // namespace procgen
