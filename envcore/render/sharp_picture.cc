#include "envcore/render/sharp_picture.h"

#include <algorithm>

#include "envcore/render/turned_picture.h"
#include "envcore/render/upright_picture.h"

namespace procgen {
namespace {

constexpr double kLargeSidePx = 16;

// Whether the turned rectangle's bounding box has a large picture's size.
bool IsLarge(const TurnedRect& turned) {
  const std::array<Point, 4> corners = turned.Corners();
  const auto [left, right] = std::minmax_element(
      corners.begin(), corners.end(), [](const Point& p, const Point& q) { return p.x < q.x; });
  const auto [top, bottom] = std::minmax_element(
      corners.begin(), corners.end(), [](const Point& p, const Point& q) { return p.y < q.y; });
  return right->x - left->x >= kLargeSidePx && bottom->y - top->y >= kLargeSidePx;
}

}  // namespace

void DrawSharp(const Picture& picture, const ScreenRect& rect, float rotation, float opacity,
               const Frame& frame) {
  const uint32_t factor = OpacityFactor(opacity);
  const Image& image = picture.LevelFor(rect.width, rect.height);
  if (rotation == 0) {
    DrawUpright(image, picture.opaque(), factor, rect, frame);
    return;
  }
  const TurnedRect turned(rect, rotation);
  if (turned.IsUpright()) {
    DrawUpright(image, picture.opaque(), factor, rect, frame);
  } else if (turned.IsHalfTurn()) {
    DrawHalfTurned(image, picture.opaque(), factor, turned, frame);
  } else if (IsLarge(turned)) {
    DrawLargeTurned(image, factor, turned, frame);
  } else {
    DrawSmallTurned(image, factor, turned, frame);
  }
}

void DrawSharpGenerated(const Picture& picture, const ScreenRect& rect, float rotation,
                        float opacity, const Frame& frame) {
  DrawGenerated(picture.LevelFor(rect.width, rect.height), OpacityFactor(opacity),
                TurnedRect(rect, rotation), frame);
}

void DrawSharpBackdrop(const Picture& picture, const ScreenRect& rect, const Frame& frame) {
  DrawBackdrop(picture.LevelFor(rect.width, rect.height), rect, frame);
}

}  // namespace procgen
