#include "envcore/render/raster/flat_rectangle.h"

#include <algorithm>
#include <utility>

#include "envcore/render/raster/coverage.h"

namespace procgen {
namespace {

uint8_t FlatChannel(uint32_t c, uint32_t a) { return static_cast<uint8_t>((c * a + 127) / 255); }

}  // namespace

PixelBox CoveredPixels(const ScreenRect& rect, int width, int height) {
  PixelBox box = {RoundPx(rect.x), RoundPx(rect.y), RoundPx(rect.x + rect.width),
                  RoundPx(rect.y + rect.height)};
  if (rect.width < 0) {
    std::swap(box.left, box.right);
  }
  if (rect.height < 0) {
    std::swap(box.top, box.bottom);
  }
  box.left = std::max(box.left, 0);
  box.top = std::max(box.top, 0);
  box.right = std::min(box.right, width);
  box.bottom = std::min(box.bottom, height);
  return box;
}

Rgba PremultipliedFlat(const Rgba& plain) {
  return {FlatChannel(plain.red, plain.alpha), FlatChannel(plain.green, plain.alpha),
          FlatChannel(plain.blue, plain.alpha), plain.alpha};
}

void DrawFlatAliased(const ScreenRect& rect, const Rgba& plain, const Frame& frame) {
  const PixelBox box = CoveredPixels(rect, frame.size_px, frame.size_px);
  if (plain.alpha == 255) {
    FillPixels(box, plain, frame);
    return;
  }
  const Rgba color = PremultipliedFlat(plain);
  for (int y = box.top; y < box.bottom; ++y) {
    Rgba* pixel = frame.At(box.left, y);
    for (int x = box.left; x < box.right; ++x, ++pixel) {
      BlendOver(color, *pixel);
    }
  }
}

void FillPixels(const PixelBox& box, const Rgba& color, const Frame& frame) {
  const int left = std::max(box.left, 0);
  const int right = std::min(box.right, frame.size_px);
  const int bottom = std::min(box.bottom, frame.size_px);
  for (int y = std::max(box.top, 0); y < bottom && left < right; ++y) {
    FillRun(frame.At(left, y), static_cast<size_t>(right - left), color);
  }
}

void DrawFlatAntialiased(const ScreenRect& rect, const Rgba& plain, const Frame& frame) {
  const Rgba color = PremultipliedFlat(plain);
  const CoveredRange columns = CoveredColumns(rect.x, rect.width, frame.size_px);
  const CoveredRange rows = CoveredColumns(rect.y, rect.height, frame.size_px);
  for (int y = rows.first; y < rows.end; ++y) {
    const double row_share = rows.ShareOf(y);
    Rgba* pixel = frame.At(columns.first, y);
    for (int x = columns.first; x < columns.end; ++x, ++pixel) {
      const auto coverage = static_cast<uint32_t>(255 * (row_share * columns.ShareOf(x)));
      BlendOver(Mul(color, coverage), *pixel);
    }
  }
}

Rgba MonochromeColor(int kind, int theme) {
  const int place = (29 * (kind + 1) + 19 * theme) % 64;
  const auto level = [](int step) { return static_cast<uint8_t>(64 * (step + 1) - 1); };
  return {level(place / 16), level(place / 4 % 4), level(place % 4), 255};
}

}  // namespace procgen
