#include "server/encoding/block_pixels.h"

#include <algorithm>

namespace procgen {
namespace {

// Compiler vectors: SSE2 or NEON where available, else words.
using Bytes8 = uint8_t __attribute__((vector_size(8)));
using Bytes16 = uint8_t __attribute__((vector_size(16)));

template <typename Vector>
Vector Load(const uint8_t* bytes) {
  Vector vector;
  std::memcpy(&vector, bytes, sizeof(vector));
  return vector;
}

// The byte-wise sum of the words of a vector.
template <typename Vector>
uint64_t FoldedBytes(const Vector& vector) {
  std::array<uint64_t, sizeof(Vector) / 8> words;
  std::memcpy(words.data(), &vector, sizeof(vector));
  uint64_t sum = 0;
  for (const uint64_t word : words) {
    sum += word;
  }
  return sum;
}

// The sum of the bytes of a word. REQUIRES: it fits in one byte; a block has at most 192.
int32_t SumOfBytes(uint64_t word) {
  return static_cast<int32_t>(word * 0x0101010101010101ULL >> 56);
}

// Comparisons yield -1 where true, hence the subtraction.
int32_t CountInWholeColorBlock(PixelRows a, PixelRows b) {
  Bytes16 left = {};
  Bytes8 right = {};
  for (int32_t row = 0; row < kBlockSide; ++row) {
    left -= reinterpret_cast<Bytes16>(Load<Bytes16>(a.Row(row)) != Load<Bytes16>(b.Row(row)));
    right -=
        reinterpret_cast<Bytes8>(Load<Bytes8>(a.Row(row) + 16) != Load<Bytes8>(b.Row(row) + 16));
  }
  return SumOfBytes(FoldedBytes(left) + FoldedBytes(right));
}

int32_t CountInWholeGrayBlock(PixelRows a, PixelRows b) {
  Bytes8 count = {};
  for (int32_t row = 0; row < kBlockSide; ++row) {
    count -= reinterpret_cast<Bytes8>(Load<Bytes8>(a.Row(row)) != Load<Bytes8>(b.Row(row)));
  }
  return SumOfBytes(FoldedBytes(count));
}

}  // namespace

PixelRows CopyAcrossEdge(const PictureShape& shape, const uint8_t* sheet, const Block& block,
                         Move move, BlockRoom& room) {
  const auto pixel_bytes = static_cast<size_t>(shape.pixel_bytes);
  const size_t stride = kBlockSide * pixel_bytes;
  const int32_t column = block.column + move.columns;
  const int32_t left = std::clamp(-column, 0, block.width);
  const int32_t right = std::clamp(column + block.width - shape.columns, 0, block.width);
  const int32_t inside = block.width - left - right;
  for (int32_t y = 0; y < block.height; ++y) {
    const int32_t row = std::clamp(block.row + move.rows + y, 0, shape.rows - 1);
    const uint8_t* line = sheet + static_cast<size_t>(row) * shape.row_bytes();
    uint8_t* pixel = room.data() + static_cast<size_t>(y) * stride;
    for (int32_t x = 0; x < left; ++x, pixel += pixel_bytes) {
      std::copy_n(line, pixel_bytes, pixel);
    }
    if (inside > 0) {
      const size_t inside_bytes = static_cast<size_t>(inside) * pixel_bytes;
      std::memcpy(pixel, line + static_cast<size_t>(column + left) * pixel_bytes, inside_bytes);
      pixel += inside_bytes;
    }
    for (int32_t x = 0; x < right; ++x, pixel += pixel_bytes) {
      std::copy_n(line + shape.row_bytes() - pixel_bytes, pixel_bytes, pixel);
    }
  }
  return {room.data(), stride};
}

int32_t CountDifferentBytes(const PictureShape& shape, const Block& block, PixelRows a,
                            PixelRows b) {
  if (block.height == kBlockSide && block.width == kBlockSide) {
    return shape.pixel_bytes == 3 ? CountInWholeColorBlock(a, b) : CountInWholeGrayBlock(a, b);
  }
  int32_t count = 0;
  for (int32_t row = 0; row < block.height; ++row) {
    for (int32_t i = 0; i < block.width * shape.pixel_bytes; ++i) {
      count += a.Row(row)[i] != b.Row(row)[i] ? 1 : 0;
    }
  }
  return count;
}

}  // namespace procgen
