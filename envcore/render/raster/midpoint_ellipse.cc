#include "envcore/render/raster/midpoint_ellipse.h"

#include <algorithm>

namespace procgen {
namespace {

// A row of the outline above the middle, and the row below that mirrors it.
struct RowPair {
  int upper_row;
  int lower_row;  // not below upper_row: no second row
  int left_first;
  int left_end;
  int right_first;
  int right_end;
};

using RowPairSink = absl::FunctionRef<void(const RowPair&)>;

// Emits the run of `length` pixels from column `first` right of the middle, `up` rows above the
// middle, and its mirror images.
void EmitRowPair(const MidpointEllipse& ellipse, int first, int up, int length, RowPairSink sink) {
  const int middle_x = ellipse.x + (ellipse.width + 1) / 2;
  const int middle_y = ellipse.y + (ellipse.height + 1) / 2;
  RowPair pair;
  pair.upper_row = middle_y - up;
  pair.lower_row = middle_y + up - ellipse.height % 2;
  pair.right_first = middle_x + first;
  pair.right_end = pair.right_first + length;
  pair.left_first = middle_x - first - (length - 1) - ellipse.width % 2;
  pair.left_end = std::min(pair.left_first + length, pair.right_first);
  sink(pair);
}

void WalkOutline(const MidpointEllipse& ellipse, RowPairSink sink) {
  if (ellipse.width <= 0 || ellipse.height <= 0) {
    return;
  }
  const double a = static_cast<double>(ellipse.width) / 2;
  const double b = static_cast<double>(ellipse.height) / 2;
  const double aa = a * a;
  const double bb = b * b;
  int x = 0;
  int y = (ellipse.height + 1) / 2;
  int run_start = 0;
  // The flat part: several pixels per row.
  double decision = bb - (aa * b) + 0.25 * aa;
  while (aa * (2 * y - 1) > 2 * bb * (x + 1)) {
    if (decision < 0) {
      decision += bb * (2 * x + 3);
      ++x;
    } else {
      decision += bb * (2 * x + 3) + aa * (2 - 2 * y);
      EmitRowPair(ellipse, run_start, y, x - run_start + 1, sink);
      ++x;
      run_start = x;
      --y;
    }
  }
  EmitRowPair(ellipse, run_start, y, x - run_start + 1, sink);
  // The steep part: one pixel per row.
  decision = bb * (x + 0.5) * (x + 0.5) + aa * ((y - 1) * (y - 1) - bb);
  while (y > ellipse.height % 2) {
    if (decision < 0) {
      decision += bb * (2 * x + 2) + aa * (3 - 2 * y);
      ++x;
    } else {
      decision += aa * (3 - 2 * y);
    }
    --y;
    EmitRowPair(ellipse, x, y, 1, sink);
  }
}

}  // namespace

void EmitMidpointEllipse(const MidpointEllipse& ellipse, int size_px, RunSink inside,
                         RunSink outline) {
  WalkOutline(ellipse, [&](const RowPair& pair) {
    const auto emit_inside = [&](int row) {
      EmitClipped(row, pair.left_end - 1, pair.right_first, size_px, size_px, inside);
    };
    const auto emit_outline = [&](int row) {
      EmitClipped(row, pair.left_first, pair.left_end, size_px, size_px, outline);
      EmitClipped(row, pair.right_first, pair.right_end, size_px, size_px, outline);
    };
    const bool two_rows = pair.upper_row < pair.lower_row;
    if (pair.left_end < pair.right_first) {
      emit_inside(pair.upper_row);
      if (two_rows) {
        emit_inside(pair.lower_row);
      }
    }
    emit_outline(pair.upper_row);
    if (two_rows) {
      emit_outline(pair.lower_row);
    }
  });
}

}  // namespace procgen
