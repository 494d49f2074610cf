#ifndef ENVCORE_WORLD_GRID_H_
#define ENVCORE_WORLD_GRID_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

inline constexpr int kNoCell = -1;  // in the place of a cell's index

// A grid of unit cells, each holding a kind.
//
//   y
//   ^            cell (x, y) covers [x, x + 1) x [y, y + 1)
//   |            cell (0, 0) is at the bottom left
//   +---> x      cell index = y * width + x
class Grid {
 public:
  Grid() = default;
  // Resizes the grid and sets all cells to `kind`.
  void Reset(int width, int height, int kind) {
    width_ = width;
    height_ = height;
    cells_.assign(static_cast<size_t>(width) * static_cast<size_t>(height),
                  static_cast<int16_t>(kind));
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int size() const { return width_ * height_; }
  bool Contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  int IndexOf(int x, int y) const { return y * width_ + x; }

  // REQUIRES: 0 <= index < size().
  int At(int index) const { return cells_[static_cast<size_t>(index)]; }
  void Set(int index, int kind) { cells_[static_cast<size_t>(index)] = static_cast<int16_t>(kind); }
  // The kinds of the cells (0, y) ... (width() - 1, y). REQUIRES: 0 <= y < height().
  absl::Span<const int16_t> Row(int y) const {
    return absl::MakeConstSpan(cells_).subspan(static_cast<size_t>(IndexOf(0, y)),
                                               static_cast<size_t>(width_));
  }
  // REQUIRES: Contains(x, y).
  int At(int x, int y) const { return At(IndexOf(x, y)); }
  void Set(int x, int y, int kind) { Set(IndexOf(x, y), kind); }
  // Fills the cells [x, x + width) x [y, y + height). REQUIRES: all of them are in the grid.
  void Fill(int x, int y, int width, int height, int kind) {
    for (int row = y; row < y + height; ++row) {
      for (int column = x; column < x + width; ++column) {
        Set(column, row, kind);
      }
    }
  }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<int16_t> cells_;  // kinds  [height, width], bottom row first
};

}  // namespace procgen

#endif  // ENVCORE_WORLD_GRID_H_
