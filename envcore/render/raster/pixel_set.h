#ifndef ENVCORE_RENDER_RASTER_PIXEL_SET_H_
#define ENVCORE_RENDER_RASTER_PIXEL_SET_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/bit_runs.h"

namespace procgen {

// Some of a frame's pixels, a bit each. Of frames of 64 x 64 at most, as a row is a word.
class PixelSet {
 public:
  // The side of the largest frame whose pixels can be told.
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

// What drawing a background may leave out, and what it has seen to.
struct BackdropPixels {
  PixelSet hidden;  // something opaque will be drawn over them
  PixelSet done;    // drawn or hidden
};

// Calls `draw(row, first, end)` for the runs of `box` that are not hidden, and calls them done.
// `pixels`: null: none is hidden. REQUIRES: the box lies in the frame.
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
