#include "server/encoding/delta.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "server/encoding/block_pixels.h"

namespace procgen {
namespace {

// The longest row of a sheet: 512 pixels.
constexpr size_t kRowBytesMax = 1536;
using RowBytes = std::array<uint8_t, kRowBytesMax>;

// The write positions of the lists. Room for a whole observation is reserved in advance, so that
// writes need no checks.
struct Pens {
  uint8_t* move_rows;
  uint8_t* move_columns;
  uint8_t* patched;
  uint8_t* masks;
  uint8_t* pixels;
};

// Appends the difference of a row `now` to `moved`: its mask and the changed pixels. Pixels are
// written unconditionally, which is faster. REQUIRES: the rows differ.
template <int kPixelBytes>
void AppendRow(const uint8_t* moved, const uint8_t* now, int32_t width, Pens& pens) {
  uint32_t mask = 0;
  for (int32_t x = 0; x < width; ++x, moved += kPixelBytes, now += kPixelBytes) {
    uint32_t differs = 0;
    for (int i = 0; i < kPixelBytes; ++i) {
      differs |= static_cast<uint32_t>(moved[i] ^ now[i]);
      pens.pixels[i] = now[i];
    }
    const uint32_t bit = differs != 0 ? 1 : 0;
    mask |= bit << x;
    pens.pixels += bit * kPixelBytes;
  }
  *pens.masks++ = static_cast<uint8_t>(mask);
}

template <int kPixelBytes>
void AppendBlock(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
                 const Block& block, Move move, Pens& pens) {
  BlockRoom room;
  const PixelRows moved = MovedPixels(shape, before, block, move, room);
  const PixelRows target = PixelsOf(shape, now, block.row, block.column);
  const size_t width_bytes = static_cast<size_t>(block.width) * kPixelBytes;
  uint32_t patched = 0;
  for (int32_t row = 0; row < block.height; ++row) {
    if (std::memcmp(moved.Row(row), target.Row(row), width_bytes) != 0) {
      AppendRow<kPixelBytes>(moved.Row(row), target.Row(row), block.width, pens);
      patched |= 1U << row;
    }
  }
  *pens.move_rows++ = static_cast<uint8_t>(move.rows);
  *pens.move_columns++ = static_cast<uint8_t>(move.columns);
  *pens.patched++ = static_cast<uint8_t>(patched);
}

// For a row of blocks: marks bytes that differ in any of its rows. Returns whether there are any.
bool CompareBand(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
                 int32_t first_row, RowBytes& differs) {
  const size_t row_bytes = shape.row_bytes();
  const size_t begin = static_cast<size_t>(first_row) * row_bytes;
  const auto height = static_cast<size_t>(std::min(kBlockSide, shape.rows - first_row));
  if (std::memcmp(before + begin, now + begin, height * row_bytes) == 0) {
    return false;
  }
  std::fill_n(differs.begin(), row_bytes, uint8_t{0});
  for (size_t at = begin; at < begin + height * row_bytes; at += row_bytes) {
    for (size_t i = 0; i < row_bytes; ++i) {
      differs[i] |= static_cast<uint8_t>(before[at + i] ^ now[at + i]);
    }
  }
  return true;
}

bool Differs(const RowBytes& differs, const Block& block, int32_t pixel_bytes) {
  const uint8_t* begin = differs.data() + static_cast<size_t>(block.column * pixel_bytes);
  return std::any_of(begin, begin + block.width * pixel_bytes,
                     [](uint8_t byte) { return byte != 0; });
}

template <int kPixelBytes>
void AppendAll(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
               MotionSearch& search, uint8_t* changed, Pens& pens) {
  RowBytes differs;
  for (int32_t first = 0; first < shape.block_count(); first += shape.block_columns()) {
    const int32_t first_row = BlockAt(shape, first).row;
    if (!CompareBand(shape, before, now, first_row, differs)) {
      continue;
    }
    for (int32_t index = first; index < first + shape.block_columns(); ++index) {
      const Block block = BlockAt(shape, index);
      if (Differs(differs, block, kPixelBytes)) {
        changed[index / 8] |= static_cast<uint8_t>(1U << (index % 8));
        const Move move = search.Find(shape, before, now, block);
        AppendBlock<kPixelBytes>(shape, before, now, block, move, pens);
      }
    }
  }
}

}  // namespace

void Delta::Clear() {
  for (ByteList* list : {&changed, &move_rows, &move_columns, &patched, &masks, &pixels}) {
    list->Clear();
  }
}

void AppendDelta(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
                 MotionSearch& search, Delta& delta) {
  uint8_t* changed = delta.changed.Room(shape.block_map_bytes());
  std::fill_n(changed, shape.block_map_bytes(), uint8_t{0});
  delta.changed.Extend(shape.block_map_bytes());
  const auto blocks = static_cast<size_t>(shape.block_count());
  // One pixel more than the maximum, for the unconditional write.
  const Pens begin = {delta.move_rows.Room(blocks), delta.move_columns.Room(blocks),
                      delta.patched.Room(blocks), delta.masks.Room(blocks * kBlockSide),
                      delta.pixels.Room(shape.bytes() + 3)};
  Pens pens = begin;
  search.BeginObservation();
  if (shape.pixel_bytes == 3) {
    AppendAll<3>(shape, before, now, search, changed, pens);
  } else {
    AppendAll<1>(shape, before, now, search, changed, pens);
  }
  delta.move_rows.Extend(static_cast<size_t>(pens.move_rows - begin.move_rows));
  delta.move_columns.Extend(static_cast<size_t>(pens.move_columns - begin.move_columns));
  delta.patched.Extend(static_cast<size_t>(pens.patched - begin.patched));
  delta.masks.Extend(static_cast<size_t>(pens.masks - begin.masks));
  delta.pixels.Extend(static_cast<size_t>(pens.pixels - begin.pixels));
}

}  // namespace procgen
