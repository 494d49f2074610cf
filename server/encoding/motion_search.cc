#include "server/encoding/motion_search.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "absl/base/attributes.h"
#include "server/encoding/block_pixels.h"

namespace procgen {
namespace {

// Blocks with fewer differing bytes are not searched.
constexpr int32_t kGoodCost = 30;
// A pattern with more matches than this says nothing about the move.
constexpr int32_t kMatchCountMax = 12;
// Searched first; the whole block is compared only where it matches.
constexpr int32_t kPatternBytes = 8;

uint64_t Load64(const uint8_t* bytes) {
  uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof(word));
  return word;
}

// A distinctive part of a row of a block: not all of one colour.
struct Pattern {
  uint64_t bytes = 0;
  int32_t row = 0;  // in the sheet
  int32_t column = 0;
  int32_t width = 0;  // pixels that it covers
};

// Finds a pattern in a block of `shape` with these pixels. Returns false if all are of one colour.
bool FindPattern(const PictureShape& shape, const Block& block, PixelRows pixels,
                 Pattern& pattern) {
  pattern.width = (kPatternBytes + shape.pixel_bytes - 1) / shape.pixel_bytes;
  // Prefers the side towards the inside of the sheet: new content appears at the edges.
  const bool left = block.column * 2 < shape.columns;
  const bool upper = block.row * 2 < shape.rows;
  const int32_t first = left ? kBlockSide - pattern.width : 0;
  pattern.column = block.column + first;
  for (int32_t i = 0; i < kBlockSide; ++i) {
    const int32_t row = upper ? kBlockSide - 1 - i : i;
    pattern.bytes = Load64(pixels.Row(row) + first * shape.pixel_bytes);
    pattern.row = block.row + row;
    // All of one colour if equal to itself shifted by a pixel.
    const uint64_t further = pattern.bytes >> (8 * shape.pixel_bytes);
    const uint64_t there = ~uint64_t{0} >> (8 * shape.pixel_bytes);
    if (((pattern.bytes ^ further) & there) != 0) {
      return true;
    }
  }
  return false;
}

// The first match of `bytes` from `pixel` to `end`, in steps of kStep bytes; beyond `end` if none.
// A separate function, so that the hot loop has all registers.
template <std::ptrdiff_t kStep>
ABSL_ATTRIBUTE_NOINLINE const uint8_t* FindBytes(const uint8_t* pixel, const uint8_t* end,
                                                 uint64_t bytes) {
  while (pixel <= end && Load64(pixel) != bytes) {
    pixel += kStep;
  }
  return pixel;
}

// Calls `use(move)` for each move within range that explains the pattern, until it returns false.
template <typename Use>
void ForEachMatch(const PictureShape& shape, const uint8_t* before, const Pattern& pattern,
                  Use use) {
  constexpr int32_t kReach = MotionSearch::kReach;
  const int32_t column_min = std::max(pattern.column - kReach, 0);
  const int32_t column_max = std::min(pattern.column + kReach, shape.columns - pattern.width);
  const int32_t row_max = std::min(pattern.row + kReach, shape.rows - 1);
  const std::ptrdiff_t step = shape.pixel_bytes;
  const auto find = step == 3 ? FindBytes<3> : FindBytes<1>;
  for (int32_t row = std::max(pattern.row - kReach, 0); row <= row_max; ++row) {
    const uint8_t* begin = PixelsOf(shape, before, row, column_min).begin;
    const uint8_t* end = begin + (column_max - column_min) * step;
    for (const uint8_t* pixel = find(begin, end, pattern.bytes); pixel <= end;
         pixel = find(pixel + step, end, pattern.bytes)) {
      const auto column = column_min + static_cast<int32_t>((pixel - begin) / step);
      if (!use(Move{static_cast<int8_t>(row - pattern.row),
                    static_cast<int8_t>(column - pattern.column)})) {
        return;
      }
    }
  }
}

// Compares a block of `now` with the results of moves.
class Trial {
 public:
  Trial(const PictureShape& shape, const uint8_t* before, const uint8_t* now, const Block& block)
      : shape_(shape),
        before_(before),
        block_(block),
        target_(PixelsOf(shape, now, block.row, block.column)) {
    Try({});
  }

  Move best() const { return best_; }
  int32_t cost() const { return cost_; }  // differing bytes with the best move

  void Try(Move move) {
    BlockRoom room;
    const PixelRows moved = MovedPixels(shape_, before_, block_, move, room);
    const int32_t cost = CountDifferentBytes(shape_, block_, moved, target_);
    if (cost < cost_) {
      best_ = move;
      cost_ = cost;
    }
  }

  void Search() {
    Pattern pattern;
    if (block_.width != kBlockSide || block_.height != kBlockSide ||
        !FindPattern(shape_, block_, target_, pattern)) {
      return;
    }
    int32_t matches_left = kMatchCountMax;
    ForEachMatch(shape_, before_, pattern, [&](Move move) {
      Try(move);
      return cost_ > 0 && --matches_left > 0;
    });
  }

 private:
  const PictureShape& shape_;
  const uint8_t* before_;
  const Block& block_;
  const PixelRows target_;
  Move best_;
  int32_t cost_ = kBlockSide * kBlockSide * 3 + 1;
};

}  // namespace

Move MotionSearch::Find(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
                        const Block& block) {
  Trial trial(shape, before, now, block);
  for (size_t i = 0; i < move_count_ && trial.cost() > 0; ++i) {
    trial.Try(moves_[i]);
  }
  if (trial.cost() >= kGoodCost && searches_left_ > 0) {
    const int32_t cost_before = trial.cost();
    trial.Search();
    if (trial.cost() * 2 >= cost_before) {
      --searches_left_;
    }
  }
  if (trial.best() != Move{}) {
    Remember(trial.best());
  }
  return trial.best();
}

void MotionSearch::Remember(Move move) {
  if (move == moves_.front()) {
    return;
  }
  Move* const known = moves_.data() + move_count_;
  Move* place = std::find(moves_.data(), known, move);
  if (place == known) {
    if (move_count_ < kMoveCount) {
      ++move_count_;
    } else {
      --place;
    }
  }
  std::rotate(moves_.data(), place, place + 1);
  moves_.front() = move;
}

}  // namespace procgen
