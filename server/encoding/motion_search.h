#ifndef SERVER_ENCODING_MOTION_SEARCH_H_
#define SERVER_ENCODING_MOTION_SEARCH_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/encoding/picture_shape.h"

namespace procgen {

// Finds from where in the last observation a block came. What moved before probably moves the same
// way again, so the moves that served last are tried first. Only a block that none of them explains
// is looked for, and only a few of each observation.
// Threads: compatible (one thread at a time).
class MotionSearch {
 public:
  // How far a block is looked for, in rows and in columns.
  static constexpr int32_t kReach = 8;
  // Moves that are remembered.
  static constexpr size_t kMoveCount = 3;
  // Blocks that are looked for in vain in one observation.
  static constexpr int32_t kVainSearchCountMax = 4;

  // The next observation begins.
  void BeginObservation() { searches_left_ = kVainSearchCountMax; }

  // The move that explains most of `block` of `now`, which differs from `before` at its own place.
  Move Find(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
            const Block& block);

 private:
  // Puts a move in front of the others.
  void Remember(Move move);

  std::array<Move, kMoveCount> moves_ = {};  // the last first
  size_t move_count_ = 0;
  int32_t searches_left_ = 0;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_MOTION_SEARCH_H_
