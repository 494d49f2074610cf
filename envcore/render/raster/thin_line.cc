#include "envcore/render/raster/thin_line.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "envcore/render/output/pixel.h"

namespace procgen {
namespace {

constexpr double kFlatness = 0.25;  // pixels
constexpr int kHalvingsMax = 6;
constexpr int64_t kNearlyParallel = 1 << 14;  // a quarter pixel per pixel, in 16.16
constexpr int64_t kCleared = std::numeric_limits<int64_t>::min();

enum class Direction { kNone, kDown, kUp, kRight, kLeft };

Direction Opposite(Direction direction) {
  switch (direction) {
    case Direction::kDown:
      return Direction::kUp;
    case Direction::kUp:
      return Direction::kDown;
    case Direction::kRight:
      return Direction::kLeft;
    case Direction::kLeft:
      return Direction::kRight;
    case Direction::kNone:
      break;
  }
  return Direction::kNone;
}

// Whether the ends of a piece have caps, in drawing direction.
struct Caps {
  bool start = false;
  bool end = false;
};

// A pixel by its positions on the main and the minor axis.
struct AxisPixel {
  int64_t main = 0;
  int64_t minor = 0;
};

// A straight piece in fixed point. The main axis is the one on which it is longer.
struct Piece {
  bool steep = false;    // the main axis is y
  bool swapped = false;  // drawn from its upper to its lower end
  Direction direction = Direction::kNone;
  int64_t main1 = 0;  // lower end in 1/64 of a pixel
  int64_t main2 = 0;  // upper end
  int64_t minor = 0;  // 16.16
  int64_t step = 0;   // change of the minor position per pixel, 16.16
  int64_t first = 0;  // range of pixels on the main axis
  int64_t end = 0;    // exclusive

  AxisPixel Lower() const { return {first, minor >> 16}; }
  AxisPixel Upper() const { return {end - 1, (minor + (end - first - 1) * step) >> 16}; }
  bool NearlyParallel() const { return std::abs(step) < kNearlyParallel; }
};

// Draws the pieces of a line or an outline. The last pixel of a piece affects the next piece.
class Pen {
 public:
  Pen(int size_px, RunSink sink) : size_px_(size_px), sink_(sink) {}

  // Updates the pen as if the piece were drawn, without drawing it.
  void Remember(Point start, Point end) {
    Piece piece;
    if (Clip(start, end) && Measure(start, end, Caps(), piece)) {
      const AxisPixel last = piece.swapped ? piece.Lower() : piece.Upper();
      Store(piece, last);
    }
  }

  void Draw(Point start, Point end, Caps caps) {
    Piece piece;
    if (!Clip(start, end) || !Measure(start, end, caps, piece)) {
      return;
    }
    AxisPixel first = piece.Lower();
    AxisPixel last = piece.Upper();
    if (piece.swapped) {
      std::swap(first, last);
    }
    JoinToMemory(first, piece, last);
    Store(piece, last);
    int64_t minor = piece.minor;
    int64_t main = piece.first;
    do {
      EmitPixel(piece.steep, {main, minor >> 16});
      minor += piece.step;
      ++main;
    } while (main < piece.end);
  }

 private:
  // Clips the piece to the surroundings of the canvas. Returns false if nothing is left.
  bool Clip(Point& start, Point& end) {
    const double low = -1;
    const double high = size_px_ + 1;
    return ClipAxis(&Point::x, &Point::y, low, high, start, end) &&
           ClipAxis(&Point::y, &Point::x, low, high, start, end);
  }

  bool ClipAxis(double Point::*along, double Point::*across, double low, double high, Point& start,
                Point& end) {
    const auto cut = [&](Point& p, double at) {
      const double slope = (end.*across - start.*across) / (end.*along - start.*along);
      p.*across += slope * (at - p.*along);
      p.*along = at;
    };
    if ((start.*along < low && end.*along <= low) || (start.*along > high && end.*along >= high)) {
      memory_x_ = kCleared;
      return false;
    }
    if (start.*along < low) {
      cut(start, low);
    } else if (start.*along > high) {
      cut(start, high);
    }
    if (end.*along < low || end.*along > high) {
      memory_x_ = kCleared;
      cut(end, end.*along < low ? low : high);
    }
    return true;
  }

  // Converts the piece to fixed point and adds its caps. Returns false if it has no pixel.
  bool Measure(const Point& start, const Point& end, Caps caps, Piece& piece) const {
    int64_t x1 = static_cast<int64_t>(start.x * 64);
    int64_t y1 = static_cast<int64_t>(start.y * 64);
    int64_t x2 = static_cast<int64_t>(end.x * 64);
    int64_t y2 = static_cast<int64_t>(end.y * 64);
    piece.steep = std::abs(x2 - x1) < std::abs(y2 - y1);
    if (piece.steep) {
      std::swap(x1, y1);
      std::swap(x2, y2);
    }
    if (x1 == x2) {
      return false;
    }
    piece.swapped = x1 > x2;
    if (piece.swapped) {
      std::swap(x1, x2);
      std::swap(y1, y2);
    }
    if (piece.steep) {
      piece.direction = piece.swapped ? Direction::kUp : Direction::kDown;
    } else {
      piece.direction = piece.swapped ? Direction::kLeft : Direction::kRight;
    }
    if (direction_ == Opposite(piece.direction)) {
      caps.start = true;
    }
    const bool lower_cap = piece.swapped ? caps.end : caps.start;
    const bool upper_cap = piece.swapped ? caps.start : caps.end;
    piece.step = (y2 - y1) * 65536 / (x2 - x1);
    piece.main1 = x1 - (lower_cap ? 32 : 0);
    piece.main2 = x2 + (upper_cap ? 32 : 0);
    piece.minor = y1 * 1024 - (lower_cap ? piece.step >> 1 : 0);
    piece.first = (piece.main1 + 32) >> 6;
    piece.end = (piece.main2 + 32) >> 6;
    if (lower_cap && (piece.steep ? memory_y_ : memory_x_) == piece.first + 1) {
      ++piece.first;
    }
    const int64_t round = piece.step > 0 ? 32 : 0;
    piece.minor += ((piece.first * 64 + round - piece.main1) * piece.step) >> 6;
    return piece.first != piece.end;
  }

  // Closes a gap to the previous piece, or skips a pixel that the previous piece has drawn.
  void JoinToMemory(const AxisPixel& first, Piece& piece, AxisPixel& last) const {
    if (memory_x_ == kCleared) {
      return;
    }
    const int64_t gap_x = std::abs(memory_x_ - (piece.steep ? first.minor : first.main));
    const int64_t gap_y = std::abs(memory_y_ - (piece.steep ? first.main : first.minor));
    const bool same_direction = direction_ == piece.direction;
    if (gap_x == 0 && gap_y == 0) {
      if (piece.swapped) {
        --piece.end;
      } else {
        ++piece.first;
        piece.minor += piece.step;
      }
    } else if (!same_direction &&
               (gap_x > 1 || gap_y > 1 ||
                (piece.NearlyParallel() && nearly_parallel_ && gap_x > 0 && gap_y > 0))) {
      if (piece.swapped) {
        ++piece.end;
      } else {
        --piece.first;
        piece.minor -= piece.step;
      }
    } else if (same_direction && gap_x <= 1 && gap_y > 1) {
      piece.minor += piece.step >> 1;
      last.minor = piece.swapped ? piece.Lower().minor : piece.Upper().minor;
    }
  }

  void Store(const Piece& piece, const AxisPixel& last) {
    memory_x_ = piece.steep ? last.minor : last.main;
    memory_y_ = piece.steep ? last.main : last.minor;
    direction_ = piece.direction;
    nearly_parallel_ = piece.NearlyParallel();
  }

  void EmitPixel(bool steep, const AxisPixel& pixel) {
    const int x = static_cast<int>(steep ? pixel.minor : pixel.main);
    const int y = static_cast<int>(steep ? pixel.main : pixel.minor);
    EmitClipped(y, x, x + 1, size_px_, size_px_, sink_);
  }

  int size_px_;
  RunSink sink_;
  int64_t memory_x_ = kCleared;  // the last pixel; only the column is cleared
  int64_t memory_y_ = kCleared;
  Direction direction_ = Direction::kNone;
  bool nearly_parallel_ = false;
};

bool IsFlat(const Curve& curve) {
  const Point& end = curve.p[3];
  const double chord_x = curve.p[0].x - end.x;
  const double chord_y = curve.p[0].y - end.y;
  const double limit = kFlatness * (std::abs(chord_x) + std::abs(chord_y));
  const auto is_near_chord = [&](const Point& control) {
    return std::abs(chord_x * (end.y - control.y) - chord_y * (end.x - control.x)) < limit;
  };
  return is_near_chord(curve.p[1]) && is_near_chord(curve.p[2]);
}

void DrawCurve(const Curve& curve, int halvings, Pen& pen) {  // NOLINT(misc-no-recursion)
  if (halvings == 0 || IsFlat(curve)) {
    pen.Draw(curve.p[0], curve.p[3], Caps());
    return;
  }
  const CurveHalves halves = Halve(curve);
  DrawCurve(halves.first, halvings - 1, pen);
  DrawCurve(halves.second, halvings - 1, pen);
}

}  // namespace

void EmitLine(const Point& start, const Point& end, int size_px, RunSink sink) {
  if (start == end) {
    EmitClipped(RoundPx(start.y), RoundPx(start.x), RoundPx(start.x) + 1, size_px, size_px, sink);
    return;
  }
  Pen(size_px, sink).Draw(start, end, {true, true});
}

void EmitOutline(absl::Span<const Curve> curves, int size_px, RunSink sink) {
  if (curves.empty()) {
    return;
  }
  Pen pen(size_px, sink);
  pen.Remember(curves.back().p[2], curves.back().p[3]);
  for (const Curve& curve : curves) {
    DrawCurve(curve, kHalvingsMax, pen);
  }
}

}  // namespace procgen
