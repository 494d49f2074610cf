#ifndef ENVCORE_RENDER_FRAME_H_
#define ENVCORE_RENDER_FRAME_H_

#include <array>
#include <cstddef>
#include <cstring>

#include "envcore/render/pixel.h"

namespace procgen {

// The largest side of a picture that can be drawn.
inline constexpr int kFrameSidePxMax = 2048;

// The picture that is being drawn: opaque pixels, top row first, Rgba [side_px, side_px]. Four
// bytes a pixel, so that a pixel is one load and one store. Does not own the memory.
struct Frame {
  Rgba* pixels = nullptr;
  int side_px = 0;

  // The pixel (x, y). REQUIRES: it lies in the frame.
  Rgba* At(int x, int y) const {
    return pixels + (static_cast<ptrdiff_t>(y) * side_px + static_cast<ptrdiff_t>(x));
  }
};

// Makes `count` pixels `color`, four at a time: compilers do it one by one.
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

#endif  // ENVCORE_RENDER_FRAME_H_
