#include "envcore/render/upright_picture.h"

#include <array>

#include "envcore/render/axis_steps.h"

namespace procgen {
namespace {

constexpr uint32_t kOpaque = 255;

// How a source pixel meets what is below.
enum class Mix { kCopy, kLayOver, kLayOverFaded };

void Put(const Rgba& source, uint8_t* pixel) {
  pixel[0] = source.red;
  pixel[1] = source.green;
  pixel[2] = source.blue;
}

template <Mix kMix>
void DrawRow(const Rgba* source, const int32_t* columns, int count, uint32_t opacity,
             uint8_t* pixel) {
  for (int i = 0; i < count; ++i, pixel += 3) {
    const Rgba& shown = source[columns[i]];
    if constexpr (kMix == Mix::kCopy) {
      Put(shown, pixel);
    } else if constexpr (kMix == Mix::kLayOverFaded) {
      LayOver(Mul(shown, opacity), pixel);
    } else if (shown.alpha == kOpaque) {
      Put(shown, pixel);
    } else if (shown.alpha != 0) {
      LayOver(shown, pixel);
    }
  }
}

void DrawStepped(const Image& image, Mix mix, uint32_t opacity, const AxisSteps& across,
                 const AxisSteps& down, const Frame& frame) {
  if (across.count <= 0 || down.count <= 0) {
    return;
  }
  std::array<int32_t, kFrameSidePxMax> columns;  // NOLINT: all that is read is written first
  int64_t position = across.position;
  for (int i = 0; i < across.count; ++i, position += across.step) {
    columns[static_cast<size_t>(i)] = static_cast<int32_t>(position >> 16);
  }
  position = down.position;
  for (int i = 0; i < down.count; ++i, position += down.step) {
    const Rgba* source = image.Row(static_cast<int>(position >> 16));
    uint8_t* pixel = frame.At(across.first, down.first + i);
    switch (mix) {
      case Mix::kCopy:
        DrawRow<Mix::kCopy>(source, columns.data(), across.count, opacity, pixel);
        break;
      case Mix::kLayOver:
        DrawRow<Mix::kLayOver>(source, columns.data(), across.count, opacity, pixel);
        break;
      case Mix::kLayOverFaded:
        DrawRow<Mix::kLayOverFaded>(source, columns.data(), across.count, opacity, pixel);
        break;
    }
  }
}

void DrawStretched(const Image& image, Mix mix, uint32_t opacity, FirstPosition first_position,
                   const ScreenRect& rect, const Frame& frame) {
  if (rect.width == image.width() && rect.height == image.height()) {
    DrawStepped(image, mix, opacity, CopiedSteps(rect.x, image.width(), frame.side_px),
                CopiedSteps(rect.y, image.height(), frame.side_px), frame);
    return;
  }
  DrawStepped(image, mix, opacity,
              StretchedSteps(rect.x, rect.width, image.width(), frame.side_px, first_position),
              StretchedSteps(rect.y, rect.height, image.height(), frame.side_px, first_position),
              frame);
}

Mix MixFor(bool opaque, uint32_t opacity) {
  if (opacity != kOpaque) {
    return Mix::kLayOverFaded;
  }
  return opaque ? Mix::kCopy : Mix::kLayOver;
}

FirstPosition FirstPositionFor(uint32_t opacity) {
  return opacity == kOpaque ? FirstPosition::kTruncatedStep : FirstPosition::kExactStep;
}

}  // namespace

void DrawUpright(const Image& image, bool opaque, uint32_t opacity, const ScreenRect& rect,
                 const Frame& frame) {
  DrawStretched(image, MixFor(opaque, opacity), opacity, FirstPositionFor(opacity), rect, frame);
}

void DrawHalfTurned(const Image& image, bool opaque, uint32_t opacity, const TurnedRect& turned,
                    const Frame& frame) {
  const std::array<Point, 4> corners = turned.Corners();
  const Point& top_left = corners[2];
  const double width = corners[0].x - top_left.x;
  const double height = corners[0].y - top_left.y;
  const FirstPosition first_position = FirstPositionFor(opacity);
  DrawStepped(image, MixFor(opaque, opacity), opacity,
              ReversedSteps(top_left.x, width, image.width(), frame.side_px, first_position),
              ReversedSteps(top_left.y, height, image.height(), frame.side_px, first_position),
              frame);
}

void DrawBackdrop(const Image& image, const ScreenRect& rect, const Frame& frame) {
  DrawStretched(image, Mix::kCopy, kOpaque, FirstPosition::kExactStep, rect, frame);
}

}  // namespace procgen
