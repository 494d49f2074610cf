#ifndef ENVCORE_RENDER_RASTER_BIT_RUNS_H_
#define ENVCORE_RENDER_RASTER_BIT_RUNS_H_

#include <algorithm>
#include <bit>
#include <cstdint>

namespace procgen {

// The pixels of a row, or the rows of a frame, as bits of a word.
inline constexpr int kWordBits = 64;

// The bits [first, end), clipped to the word.
inline uint64_t BitRange(int first, int end) {
  const int from = std::max(first, 0);
  const int to = std::min(end, kWordBits);
  if (from >= to) {
    return 0;
  }
  return (~uint64_t{0} >> (kWordBits - (to - from))) << from;
}

// Calls `use(first, end)` for each run of 1 bits.
template <typename Use>
void ForEachBitRun(uint64_t bits, Use use) {
  while (bits != 0) {
    const int first = std::countr_zero(bits);
    const int end = first + std::countr_one(bits >> first);
    use(first, end);
    bits &= ~BitRange(first, end);
  }
}

}  // namespace procgen

#endif  // ENVCORE_RENDER_RASTER_BIT_RUNS_H_
