#include "tools/art/sprite_sheet.h"

#include <algorithm>

#include "envcore/render/art/antialiased_sampling.h"
#include "envcore/render/art/nearest_sampling.h"
#include "envcore/render/output/frame.h"

namespace procgen {
namespace {

constexpr Rgba kBackdropColors[] = {{226, 224, 214, 255}, {44, 48, 60, 255}};
constexpr int kLargeSizePx = 168;
constexpr int kMarginPx = 4;
constexpr int kSmallSidesPx[] = {4, 6, 9};
constexpr int kSmallFactor = 8;  // factor for the small images
constexpr int kSmallHeightPx = 9 * kSmallFactor + 2 * kMarginPx;

// The largest centered rectangle with the image's aspect ratio.
ScreenRect InMiddle(const MipmappedImage& picture, int size_px, double length_px) {
  const Image& image = picture.level(0);
  const double scale = length_px / std::max(image.width(), image.height());
  const double width = image.width() * scale;
  const double height = image.height() * scale;
  return {(size_px - width) / 2, (size_px - height) / 2, width, height};
}

// A square of one color.
Image PlainBackdrop(int size_px, const Rgba& color) {
  Image image(size_px, size_px);
  std::fill_n(image.Row(0), size_px * size_px, color);
  return image;
}

// Each pixel becomes factor x factor pixels.
Image Enlarged(const Image& image, int factor) {
  Image enlarged(image.width() * factor, image.height() * factor);
  for (int y = 0; y < enlarged.height(); ++y) {
    for (int x = 0; x < enlarged.width(); ++x) {
      enlarged.At(x, y) = image.At(x / factor, y / factor);
    }
  }
  return enlarged;
}

// REQUIRES: `source` fits into `target` at (left, top).
void Paste(const Image& source, int left, int top, Image* target) {
  for (int y = 0; y < source.height(); ++y) {
    std::copy_n(source.Row(y), source.width(), target->Row(top + y) + left);
  }
}

}  // namespace

Image SpriteSheet(const MipmappedImage& picture) {
  Image sheet(2 * kLargeSizePx, kLargeSizePx + kSmallHeightPx);
  int left = 0;
  for (const Rgba& color : kBackdropColors) {
    Image large = PlainBackdrop(kLargeSizePx, color);
    DrawAntialiased(picture, InMiddle(picture, kLargeSizePx, kLargeSizePx - 2 * kMarginPx), 0, 1,
                    {large.Row(0), kLargeSizePx});
    Paste(large, left, 0, &sheet);
    for (int y = 0; y < kSmallHeightPx; ++y) {
      std::fill_n(sheet.Row(kLargeSizePx + y) + left, kLargeSizePx, color);
    }
    int small_left = left + kMarginPx;
    for (const int side : kSmallSidesPx) {
      Image small = PlainBackdrop(side, color);
      DrawNearest(picture, InMiddle(picture, side, side), 0, 1, {small.Row(0), side});
      Paste(Enlarged(small, kSmallFactor), small_left, kLargeSizePx + kMarginPx, &sheet);
      small_left += side * kSmallFactor + kMarginPx;
    }
    left += kLargeSizePx;
  }
  return sheet;
}

}  // namespace procgen
