#ifndef SERVER_ENCODING_PICTURE_SHAPE_H_
#define SERVER_ENCODING_PICTURE_SHAPE_H_

#include <cstddef>
#include <cstdint>

namespace procgen {

// Blocks have this many rows and pixels per row; at the last row and column fewer.
inline constexpr int32_t kBlockSide = 8;

// An observation as a sheet of `rows` rows of `columns` pixels, of `pixel_bytes` bytes each. Planes
// and the frames of a stack are stacked vertically, as in memory:
//
//                      rows                     columns   pixel_bytes   stack
//     [side, side, C]     side                  side      C             1
//     [C, side, side]     C * side              side      1             1
//     [k, ...]            k times as many       side      as above      k
struct PictureShape {
  int32_t rows = 0;
  int32_t columns = 0;
  int32_t pixel_bytes = 0;  // 1 or 3
  int32_t stack = 1;        // divides rows

  size_t row_bytes() const { return static_cast<size_t>(columns) * pixel_bytes; }
  size_t bytes() const { return static_cast<size_t>(rows) * row_bytes(); }
  int32_t block_rows() const { return (rows + kBlockSide - 1) / kBlockSide; }
  int32_t block_columns() const { return (columns + kBlockSide - 1) / kBlockSide; }
  int32_t block_count() const { return block_rows() * block_columns(); }
  // Bytes of a bitmap with one bit per block.
  size_t block_map_bytes() const { return (static_cast<size_t>(block_count()) + 7) / 8; }
};

// A rectangle of the sheet, in rows and pixels.
struct Block {
  int32_t row = 0;
  int32_t column = 0;
  int32_t height = 0;
  int32_t width = 0;
};

// Block `index`, in row-major order.
inline Block BlockAt(const PictureShape& shape, int32_t index) {
  Block block;
  block.row = index / shape.block_columns() * kBlockSide;
  block.column = index % shape.block_columns() * kBlockSide;
  block.height = shape.rows - block.row < kBlockSide ? shape.rows - block.row : kBlockSide;
  block.width =
      shape.columns - block.column < kBlockSide ? shape.columns - block.column : kBlockSide;
  return block;
}

// The source of a block: this many rows below and pixels to the right of its place.
struct Move {
  int8_t rows = 0;
  int8_t columns = 0;

  bool operator==(const Move& other) const = default;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_PICTURE_SHAPE_H_
