#include "envcore/render/art/nearest_sampling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

#include "envcore/render/art/rotated_image.h"
#include "envcore/render/art/scaled_drawing.h"
#include "envcore/render/art/upright_image.h"

namespace procgen {
namespace {

constexpr double kLargeSizePx = 16;
// Largest background that is kept scaled: the largest world drawn at 64 x 64. Pixels.
constexpr double kScaledBackdropPixelsMax = 1 << 19;
constexpr double kHairPx = 1e-6;  // smaller differences are rounding errors
// Smallest number of source pixels per pixel of a larger background, on each axis.
constexpr double kLargeBackdropShare = 0.6;

// The pixels that a rectangle covers; may be outside the frame.
PixelBox Rounded(const ScreenRect& rect) {
  return {RoundPx(rect.x), RoundPx(rect.y), RoundPx(rect.x + rect.width),
          RoundPx(rect.y + rect.height)};
}

// Largest number of pixels that a length covers at any position. `covered`: the number at the
// current position.
int MostPixels(double length, int covered) {
  return std::max(covered, static_cast<int>(std::ceil(length - kHairPx)));
}

// Whether the bounding box of the rotated rectangle counts as large in the drawing rules.
bool IsLarge(const RotatedRect& rotated) {
  const std::array<Point, 4> corners = rotated.Corners();
  const auto [left, right] = std::minmax_element(
      corners.begin(), corners.end(), [](const Point& p, const Point& q) { return p.x < q.x; });
  const auto [top, bottom] = std::minmax_element(
      corners.begin(), corners.end(), [](const Point& p, const Point& q) { return p.y < q.y; });
  return right->x - left->x >= kLargeSizePx && bottom->y - top->y >= kLargeSizePx;
}

// The nearest angle for scaled copies, in [0, kAngleCount).
int AngleOf(float rotation) {
  constexpr double kAnglesPerRadian = kAngleCount / (2 * std::numbers::pi);
  static_assert((kAngleCount & (kAngleCount - 1)) == 0);
  return RoundPx(static_cast<double>(rotation) * kAnglesPerRadian) & (kAngleCount - 1);
}

// Draws an image that scales() into the whole pixels that it covers. Returns false if it is too
// large.
bool DrawWhole(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
               uint32_t opacity, const Frame& frame) {
  const PixelBox box = Rounded(rect);
  ScaledSize size = {box.width(), box.height(), 0};
  if (size.width > ScaledImageCache::kSizePxMax || size.height > ScaledImageCache::kSizePxMax) {
    return false;
  }
  if (rotation == 0) {
    if (!box.IsEmpty()) {
      DrawScaled(*picture.ScaledTo(size), box.left, box.top, opacity, frame);
    }
    return true;
  }
  // A rotated image has the same size at every position.
  size = {std::max(1, RoundPx(rect.width)), std::max(1, RoundPx(rect.height)), AngleOf(rotation)};
  const std::shared_ptr<const ScaledImage> scaled = picture.ScaledTo(size);
  DrawScaled(*scaled, RoundPx(rect.x + (rect.width - scaled->image.width()) / 2),
             RoundPx(rect.y + (rect.height - scaled->image.height()) / 2), opacity, frame);
  return true;
}

}  // namespace

void DrawNearest(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                 float opacity, const Frame& frame) {
  const uint32_t factor = OpacityFactor(opacity);
  if (picture.scales() && DrawWhole(picture, rect, rotation, factor, frame)) {
    return;
  }
  const Image& image = picture.LevelFor(rect.width, rect.height);
  if (rotation == 0) {
    DrawUpright(image, picture.opaque(), factor, rect, frame);
    return;
  }
  const RotatedRect rotated(rect, rotation);
  if (rotated.IsUpright()) {
    DrawUpright(image, picture.opaque(), factor, rect, frame);
  } else if (rotated.IsHalfTurn()) {
    DrawHalfTurn(image, picture.opaque(), factor, rotated, frame);
  } else if (IsLarge(rotated)) {
    DrawLargeRotated(image, factor, rotated, frame);
  } else {
    DrawSmallRotated(image, factor, rotated, frame);
  }
}

void DrawNearestGenerated(const MipmappedImage& picture, const ScreenRect& rect, float rotation,
                          float opacity, const Frame& frame) {
  DrawGenerated(picture.LevelFor(rect.width, rect.height), OpacityFactor(opacity),
                RotatedRect(rect, rotation), frame);
}

void DrawNearestBackdrop(const MipmappedImage& picture, const ScreenRect& rect,
                         BackdropMotion motion, BackdropPixels* pixels, const Frame& frame) {
  const PixelBox box = Rounded(rect);
  if (frame.Cut(box).IsEmpty()) {
    return;
  }
  if (picture.scales() && rect.width * rect.height <= kScaledBackdropPixelsMax) {
    // Scale to the largest number of pixels that the rectangle covers at any position, so that one
    // copy serves all positions.
    const ScaledSize size = {.width = MostPixels(rect.width, box.width()),
                             .height = MostPixels(rect.height, box.height())};
    if (const std::shared_ptr<const ScaledImage> scaled = picture.KeptAt(size)) {
      DrawScaledBackdrop(scaled->image, box, pixels, frame);
    } else {
      const PixelBox seen = frame.Cut(box);
      DrawScaledBackdrop(picture.PartAt(size, {seen.left - box.left, seen.top - box.top,
                                               seen.right - box.left, seen.bottom - box.top}),
                         seen, pixels, frame);
    }
    return;
  }
  // The view shows only a small part of a large background. A smaller level fits the caches better.
  const double share = picture.scales() ? kLargeBackdropShare : 1;
  DrawBackdrop(picture.LevelFor(rect.width * share, rect.height * share), rect, motion,
               picture.column_copies(), pixels, frame);
}

}  // namespace procgen
