#ifndef ENVCORE_RENDER_HIDDEN_PIXELS_H_
#define ENVCORE_RENDER_HIDDEN_PIXELS_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace procgen {

// The side of the largest frame whose hidden pixels are told.
inline constexpr int kHiddenSidePxMax = 64;

// Pixels that need not be drawn, as something opaque will be drawn over them: a bit each.
class HiddenPixels {
 public:
  void Clear() { rows_.fill(0); }

  // REQUIRES: 0 <= row < kHiddenSidePxMax.
  void Add(int row, uint64_t columns) { rows_[static_cast<size_t>(row)] |= columns; }

  // The columns [first, end), cut to the frame.
  static uint64_t Columns(int first, int end) {
    const int from = std::max(first, 0);
    const int to = std::min(end, kHiddenSidePxMax);
    if (from >= to) {
      return 0;
    }
    return (~uint64_t{0} >> (kHiddenSidePxMax - (to - from))) << from;
  }

  // Calls `draw(first, end)` for the runs of [first, end) in `row` that are not hidden.
  // REQUIRES: 0 <= row < kHiddenSidePxMax.
  template <typename Draw>
  void ForEachShown(int row, int first, int end, Draw draw) const {
    uint64_t shown = Columns(first, end) & ~rows_[static_cast<size_t>(row)];
    while (shown != 0) {
      const int from = std::countr_zero(shown);
      const int count = std::countr_one(shown >> from);
      draw(from, from + count);
      shown &= ~Columns(from, from + count);
    }
  }

 private:
  std::array<uint64_t, kHiddenSidePxMax> rows_ = {};
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_HIDDEN_PIXELS_H_
