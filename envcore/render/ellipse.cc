#include "envcore/render/ellipse.h"

#include <array>
#include <cmath>
#include <optional>

#include "envcore/render/curve.h"
#include "envcore/render/midpoint_ellipse.h"
#include "envcore/render/polygon.h"
#include "envcore/render/thin_line.h"

namespace procgen {
namespace {

bool IsDrawable(const ScreenRect& rect) {
  constexpr double kFarPx = 1e6;
  return rect.width > 0 && rect.height > 0 && rect.width < kFarPx && rect.height < kFarPx &&
         std::abs(rect.x) < kFarPx && std::abs(rect.y) < kFarPx;
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

void EmitEllipseInside(const ScreenRect& rect, int side_px, RunSink sink) {
  if (!IsDrawable(rect)) {
    return;
  }
  if (const auto whole = WholePixels(rect)) {
    EmitInside(*whole, side_px, sink);
    return;
  }
  EmitInside(EllipseCurves(rect), side_px, sink);
}

void EmitEllipseOutline(const ScreenRect& rect, int side_px, RunSink sink) {
  if (!IsDrawable(rect)) {
    return;
  }
  if (const auto whole = WholePixels(rect)) {
    EmitOutline(*whole, side_px, sink);
    return;
  }
  EmitOutline(EllipseCurves(rect), side_px, sink);
}

}  // namespace procgen
