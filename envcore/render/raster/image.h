#ifndef ENVCORE_RENDER_RASTER_IMAGE_H_
#define ENVCORE_RENDER_RASTER_IMAGE_H_

#include <algorithm>
#include <cstddef>
#include <vector>

#include "envcore/render/output/pixel.h"

namespace procgen {

// Pixels with premultiplied alpha, row-major, top row first: Rgba [height, width].
class Image {
 public:
  Image() = default;
  // Makes an image of transparent pixels.
  Image(int width, int height)
      : width_(width),
        height_(height),
        pixels_(static_cast<size_t>(width) * static_cast<size_t>(height)) {}

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return pixels_.empty(); }

  // REQUIRES: 0 <= y < height().
  const Rgba* Row(int y) const { return pixels_.data() + Offset(y); }
  Rgba* Row(int y) { return pixels_.data() + Offset(y); }
  // REQUIRES: the pixel is in the image.
  const Rgba& At(int x, int y) const { return Row(y)[x]; }
  Rgba& At(int x, int y) { return Row(y)[x]; }

 private:
  size_t Offset(int y) const { return static_cast<size_t>(y) * static_cast<size_t>(width_); }

  int width_ = 0;
  int height_ = 0;
  std::vector<Rgba> pixels_;
};

// Whether every pixel is opaque.
inline bool IsOpaque(const Image& image) {
  for (int y = 0; y < image.height(); ++y) {
    const Rgba* row = image.Row(y);
    if (!std::all_of(row, row + image.width(), [](const Rgba& p) { return p.alpha == 255; })) {
      return false;
    }
  }
  return true;
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_IMAGE_H_
