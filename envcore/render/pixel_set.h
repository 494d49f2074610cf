#ifndef ENVCORE_RENDER_PIXEL_SET_H_
#define ENVCORE_RENDER_PIXEL_SET_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "envcore/render/frame.h"

namespace procgen {

// Some of a frame's pixels, a bit each. Of frames of 64 x 64 at most, as a row is a word.
class PixelSet {
 public:
  // The side of the largest frame whose pixels can be told.
  static constexpr int kSidePxMax = 64;

  // REQUIRES: 0 <= row < kSidePxMax.
  void Add(int row, uint64_t columns) { rows_[static_cast<size_t>(row)] |= columns; }

  // The columns [first, end), cut to the frame.
  static uint64_t Columns(int first, int end) {
    const int from = std::max(first, 0);
    const int to = std::min(end, kSidePxMax);
    if (from >= to) {
      return 0;
    }
    return (~uint64_t{0} >> (kSidePxMax - (to - from))) << from;
  }

  // Calls `use(first, end)` for the runs of [first, end) in `row` that are not in the set.
  // REQUIRES: 0 <= row < kSidePxMax.
  template <typename Use>
  void ForEachRunOutside(int row, int first, int end, Use use) const {
    uint64_t outside = Columns(first, end) & ~rows_[static_cast<size_t>(row)];
    while (outside != 0) {
      const int from = std::countr_zero(outside);
      const int count = std::countr_one(outside >> from);
      use(from, from + count);
      outside &= ~Columns(from, from + count);
    }
  }

 private:
  std::array<uint64_t, kSidePxMax> rows_ = {};
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
  const uint64_t columns = PixelSet::Columns(box.left, box.right);
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

#endif  // ENVCORE_RENDER_PIXEL_SET_H_
