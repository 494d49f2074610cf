#include "envcore/render/raster/ellipse.h"

#include <array>
#include <cmath>
#include <optional>

#include "envcore/render/raster/curve.h"
#include "envcore/render/raster/midpoint_ellipse.h"
#include "envcore/render/raster/polygon.h"
#include "envcore/render/raster/thin_line.h"

namespace procgen {
namespace {

// Ellipses that are larger or farther away are not drawn.
constexpr double kReachPx = 1e6;

bool IsDrawable(const ScreenRect& rect) {
  return rect.width > 0 && rect.height > 0 && rect.width < kReachPx && rect.height < kReachPx &&
         std::abs(rect.x) < kReachPx && std::abs(rect.y) < kReachPx;
}

std::optional<MidpointEllipse> WholePixels(const ScreenRect& rect) {
  for (const double v : {rect.x, rect.y, rect.width, rect.height}) {
    if (v != std::floor(v)) {
      return std::nullopt;
    }
  }
  return MidpointEllipse{static_cast<int>(rect.x), static_cast<int>(rect.y),
                         static_cast<int>(rect.width), static_cast<int>(rect.height)};
}

}  // namespace

void EmitEllipse(const ScreenRect& rect, int size_px, RunSink inside, RunSink outline) {
  if (!IsDrawable(rect)) {
    return;
  }
  if (const auto whole = WholePixels(rect)) {
    EmitMidpointEllipse(*whole, size_px, inside, outline);
    return;
  }
  const std::array<Curve, 4> curves = EllipseCurves(rect);
  EmitInside(curves, size_px, inside);
  EmitOutline(curves, size_px, outline);
}

void EmitEllipseInside(const ScreenRect& rect, int size_px, RunSink inside) {
  EmitEllipse(rect, size_px, inside, [](int /*row*/, int /*first*/, int /*end*/) {});
}

}  // namespace procgen
