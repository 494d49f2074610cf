#ifndef SERVER_ENCODING_BLOCK_PIXELS_H_
#define SERVER_ENCODING_BLOCK_PIXELS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "server/encoding/picture_shape.h"

namespace procgen {

// The pixels of a block; rows are `stride` bytes apart.
struct PixelRows {
  const uint8_t* begin = nullptr;
  size_t stride = 0;

  const uint8_t* Row(int32_t row) const { return begin + static_cast<size_t>(row) * stride; }
};

// Room for the pixels of one block.
using BlockRoom = std::array<uint8_t, static_cast<size_t>(kBlockSide) * kBlockSide * 3>;

// The pixels of a block of `sheet`, in place.
inline PixelRows PixelsOf(const PictureShape& shape, const uint8_t* sheet, int32_t row,
                          int32_t column) {
  const size_t stride = shape.row_bytes();
  return {sheet + static_cast<size_t>(row) * stride +
              static_cast<size_t>(column) * static_cast<size_t>(shape.pixel_bytes),
          stride};
}

// The slow path of MovedPixels at the edge of the sheet: copies to `room`.
PixelRows CopyAcrossEdge(const PictureShape& shape, const uint8_t* sheet, const Block& block,
                         Move move, BlockRoom& room);

// The pixels of `block` moved by `move` in `sheet`. Beyond the sheet its edge pixels repeat. Points
// into the sheet or, at its edge, into `room`.
inline PixelRows MovedPixels(const PictureShape& shape, const uint8_t* sheet, const Block& block,
                             Move move, BlockRoom& room) {
  const int32_t row = block.row + move.rows;
  const int32_t column = block.column + move.columns;
  if (row >= 0 && column >= 0 && row + block.height <= shape.rows &&
      column + block.width <= shape.columns) {
    return PixelsOf(shape, sheet, row, column);
  }
  return CopyAcrossEdge(shape, sheet, block, move, room);
}

// Number of bytes in which two blocks differ.
int32_t CountDifferentBytes(const PictureShape& shape, const Block& block, PixelRows a,
                            PixelRows b);

}  // namespace procgen

#endif  // SERVER_ENCODING_BLOCK_PIXELS_H_
