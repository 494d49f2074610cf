#ifndef ENVCORE_RENDER_RASTER_PIXEL_SET_H_
#define ENVCORE_RENDER_RASTER_PIXEL_SET_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/bit_runs.h"

namespace procgen {

// A set of pixels of a frame of at most 64 x 64: one bit per pixel, one word per row.
class PixelSet {
 public:
  // Size of the largest frame that a set can cover.
  static constexpr int kSizePxMax = kWordBits;

  // REQUIRES: 0 <= row < kSizePxMax.
  void Add(int row, uint64_t columns) { rows_[static_cast<size_t>(row)] |= columns; }

  // Calls `use(first, end)` for the runs of [first, end) in `row` that are not in the set.
  // REQUIRES: 0 <= row < kSizePxMax.
  template <typename Use>
  void ForEachRunOutside(int row, int first, int end, Use use) const {
    ForEachBitRun(BitRange(first, end) & ~rows_[static_cast<size_t>(row)], use);
  }

 private:
  std::array<uint64_t, kSizePxMax> rows_ = {};
};

// The pixels that a background need not draw, and those that are done.
struct BackdropPixels {
  PixelSet hidden;  // will be covered by something opaque
  PixelSet done;    // drawn or hidden
};

// Calls `draw(row, first, end)` for the runs of `box` that are not hidden, and marks them done.
// `pixels`: null: no pixel is hidden. REQUIRES: the box is in the frame.
template <typename Draw>
void ForEachRunToDraw(const PixelBox& box, BackdropPixels* pixels, Draw draw) {
  const uint64_t columns = BitRange(box.left, box.right);
  for (int row = box.top; row < box.bottom && box.left < box.right; ++row) {
    if (pixels == nullptr) {
      draw(row, box.left, box.right);
      continue;
    }
    pixels->hidden.ForEachRunOutside(row, box.left, box.right,
                                     [&](int first, int end) { draw(row, first, end); });
    pixels->done.Add(row, columns);
  }
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_PIXEL_SET_H_
