#ifndef ENVCORE_RENDER_FRAME_H_
#define ENVCORE_RENDER_FRAME_H_

#include <cstddef>
#include <cstdint>

namespace procgen {

// The largest side of a picture that can be drawn.
inline constexpr int kFrameSidePxMax = 2048;

// The caller's buffer that a picture is drawn into: red, green, blue, top row first,
// uint8 [side_px, side_px, 3]. Does not own the memory.
struct Frame {
  uint8_t* rgb = nullptr;
  int side_px = 0;

  // The pixel (x, y). REQUIRES: it lies in the frame.
  uint8_t* At(int x, int y) const {
    return rgb + 3 * (static_cast<ptrdiff_t>(y) * side_px + static_cast<ptrdiff_t>(x));
  }
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_FRAME_H_
