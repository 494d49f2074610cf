#ifndef ENVCORE_RENDER_OUTPUT_FRAME_H_
#define ENVCORE_RENDER_OUTPUT_FRAME_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "absl/types/span.h"
#include "envcore/render/output/pixel.h"

namespace procgen {

// Largest size of a frame in pixels.
inline constexpr int kFrameSizePxMax = 2048;

// The pixels [left, right) x [top, bottom).
struct PixelBox {
  int width() const { return right - left; }
  int height() const { return bottom - top; }
  bool IsEmpty() const { return width() <= 0 || height() <= 0; }

  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
};

// The frame that is being drawn: opaque pixels, top row first, Rgba [size_px, size_px]. With four
// bytes per pixel, a pixel is one load and one store. Does not own the memory.
struct Frame {
  Rgba* pixels = nullptr;
  int size_px = 0;

  // The pixel (x, y). REQUIRES: it is in the frame.
  Rgba* At(int x, int y) const {
    return pixels + (static_cast<ptrdiff_t>(y) * size_px + static_cast<ptrdiff_t>(x));
  }

  // The pixels of the rows [first, end). REQUIRES: they are in the frame.
  absl::Span<Rgba> Rows(int first, int end) const {
    return {At(0, first), static_cast<size_t>(end - first) * static_cast<size_t>(size_px)};
  }

  // The part of `box` inside the frame; may be empty.
  PixelBox Cut(const PixelBox& box) const {
    return {std::max(box.left, 0), std::max(box.top, 0), std::min(box.right, size_px),
            std::min(box.bottom, size_px)};
  }
};

// Sets `count` pixels to `color`, four at a time: compilers do not vectorize the plain loop.
inline void FillRun(Rgba* pixels, size_t count, const Rgba& color) {
  const std::array<Rgba, 4> four = {color, color, color, color};
  for (; count >= four.size(); count -= four.size(), pixels += four.size()) {
    std::memcpy(pixels, four.data(), sizeof(four));
  }
  for (; count > 0; --count) {
    *pixels++ = color;
  }
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_OUTPUT_FRAME_H_
