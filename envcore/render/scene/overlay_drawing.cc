#include "envcore/render/scene/overlay_drawing.h"

#include <algorithm>
#include <cmath>

#include "envcore/render/raster/coverage.h"
#include "envcore/render/raster/ellipse.h"
#include "envcore/render/raster/flat_rectangle.h"
#include "envcore/render/raster/thin_line.h"

namespace procgen {
namespace {

constexpr double kNeedleShare = 0.95;  // fraction of half the rectangle's width
constexpr Rgba kJumpMarkColor = {255, 255, 255, 120};
constexpr int kSamplesPerSide = 4;  // per pixel, in the human view

Rgba ColorOf(const Overlay& overlay) {
  return {overlay.color[0], overlay.color[1], overlay.color[2], 255};
}

// The overlay's rectangle in pixels, each value rounded to f32.
ScreenRect RectOf(const Overlay& overlay, const Viewport& viewport) {
  const float u = viewport.pixels_per_cell();
  return {overlay.x * u, overlay.y * u, overlay.width * u, overlay.height * u};
}

// The lower part of a box, in whole pixels.
ScreenRect JumpMarkRectOf(const Overlay& overlay, const Viewport& viewport) {
  const ScreenRect box = viewport.OfBox(overlay.x, overlay.y, overlay.width, overlay.height);
  return {std::trunc(box.x), std::trunc(box.y + box.height * (5.0 / 6.0)), std::trunc(box.width),
          std::trunc(box.height / 3)};
}

struct Needle {
  Point start;
  Point end;
};

Needle NeedleOf(const Overlay& overlay, const ScreenRect& rect) {
  const auto x = static_cast<double>(static_cast<float>(rect.x + rect.width / 2));
  const auto y = static_cast<double>(static_cast<float>(rect.y + rect.height / 2));
  const auto length = static_cast<double>(static_cast<float>(rect.width / 2 * kNeedleShare));
  const auto angle = static_cast<double>(overlay.angle);
  return {{std::trunc(x), std::trunc(y)},
          {std::trunc(x + length * std::cos(angle)), std::trunc(y - length * std::sin(angle))}};
}

// Blends `plain` over every pixel, weighted by the samples for which `inside` holds. `bounds`
// contains everything inside.
template <typename Inside>
void FillAntialiased(const ScreenRect& bounds, const Rgba& plain, const Frame& frame,
                     Inside inside) {
  const Rgba color = PremultipliedFlat(plain);
  const CoveredRange columns = CoveredColumns(bounds.x, bounds.width, frame.size_px);
  const CoveredRange rows = CoveredColumns(bounds.y, bounds.height, frame.size_px);
  for (int y = rows.first; y < rows.end; ++y) {
    for (int x = columns.first; x < columns.end; ++x) {
      uint32_t hits = 0;
      for (int i = 0; i < kSamplesPerSide * kSamplesPerSide; ++i) {
        const int column = i % kSamplesPerSide;
        const int row = i / kSamplesPerSide;
        const double sample_x = x + (column + 0.5) / kSamplesPerSide;
        const double sample_y = y + (row + 0.5) / kSamplesPerSide;
        hits += inside(sample_x, sample_y) ? 1U : 0U;
      }
      if (hits > 0) {
        const uint32_t coverage = 255 * hits / (kSamplesPerSide * kSamplesPerSide);
        BlendOver(Mul(color, coverage), *frame.At(x, y));
      }
    }
  }
}

void FillEllipseAntialiased(const ScreenRect& rect, const Rgba& plain, const Frame& frame) {
  const double half_w = rect.width / 2;
  const double half_h = rect.height / 2;
  if (!(half_w > 0) || !(half_h > 0)) {
    return;
  }
  FillAntialiased(rect, plain, frame, [&](double x, double y) {
    const double a = (x - rect.x - half_w) / half_w;
    const double b = (y - rect.y - half_h) / half_h;
    return a * a + b * b <= 1;
  });
}

// A line with square ends that extend half its width beyond its end points.
void DrawNeedleAntialiased(const Needle& needle, double width, const Rgba& plain,
                           const Frame& frame) {
  const double dx = needle.end.x - needle.start.x;
  const double dy = needle.end.y - needle.start.y;
  const double length = std::sqrt(dx * dx + dy * dy);
  const double along_x = length > 0 ? dx / length : 1;
  const double along_y = length > 0 ? dy / length : 0;
  const ScreenRect bounds = {std::min(needle.start.x, needle.end.x) - width,
                             std::min(needle.start.y, needle.end.y) - width,
                             std::abs(dx) + 2 * width, std::abs(dy) + 2 * width};
  FillAntialiased(bounds, plain, frame, [&](double x, double y) {
    const double from_x = x - needle.start.x;
    const double from_y = y - needle.start.y;
    const double along = from_x * along_x + from_y * along_y;
    const double across = from_y * along_x - from_x * along_y;
    return along >= -width / 2 && along <= length + width / 2 && std::abs(across) <= width / 2;
  });
}

}  // namespace

RowRange RowsOf(const Overlay& overlay, const Viewport& viewport) {
  if (overlay.shape != Overlay::Shape::kRectangle) {
    return {0, viewport.size_px()};
  }
  const ScreenRect rect = RectOf(overlay, viewport);
  const PixelBox box = CoveredPixels(rect, viewport.size_px(), viewport.size_px());
  return {box.top, box.bottom};
}

void DrawOverlayAliased(const Overlay& overlay, const Viewport& viewport, const Frame& frame) {
  const ScreenRect rect = RectOf(overlay, viewport);
  const auto lay = [&frame](const Rgba& plain) {
    return [&frame, color = PremultipliedFlat(plain)](int row, int first, int end) {
      for (int x = first; x < end; ++x) {
        BlendOver(color, *frame.At(x, row));
      }
    };
  };
  switch (overlay.shape) {
    case Overlay::Shape::kRectangle:
      DrawFlatAliased(rect, ColorOf(overlay), frame);
      break;
    case Overlay::Shape::kDisc:
      EmitEllipse(rect, frame.size_px, lay(ColorOf(overlay)), lay(ColorOf(overlay)));
      break;
    case Overlay::Shape::kNeedle: {
      const Needle needle = NeedleOf(overlay, rect);
      EmitLine(needle.start, needle.end, frame.size_px, lay(ColorOf(overlay)));
      break;
    }
    case Overlay::Shape::kJumpMark:
      EmitEllipseInside(JumpMarkRectOf(overlay, viewport), frame.size_px, lay(kJumpMarkColor));
      break;
  }
}

void DrawOverlayAntialiased(const Overlay& overlay, const Viewport& viewport, const Frame& frame) {
  const ScreenRect rect = RectOf(overlay, viewport);
  switch (overlay.shape) {
    case Overlay::Shape::kRectangle:
      DrawFlatAntialiased(rect, ColorOf(overlay), frame);
      break;
    case Overlay::Shape::kDisc:  // the outline adds half a pixel
      FillEllipseAntialiased({rect.x - 0.5, rect.y - 0.5, rect.width + 1, rect.height + 1},
                             ColorOf(overlay), frame);
      break;
    case Overlay::Shape::kNeedle: {
      const double width =
          std::max(1.0, std::trunc(frame.size_px / (256.0 / static_cast<double>(overlay.width))));
      DrawNeedleAntialiased(NeedleOf(overlay, rect), width, ColorOf(overlay), frame);
      break;
    }
    case Overlay::Shape::kJumpMark:
      FillEllipseAntialiased(JumpMarkRectOf(overlay, viewport), kJumpMarkColor, frame);
      break;
  }
}

}  // namespace procgen
