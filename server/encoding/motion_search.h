#ifndef SERVER_ENCODING_MOTION_SEARCH_H_
#define SERVER_ENCODING_MOTION_SEARCH_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/encoding/picture_shape.h"

namespace procgen {

// Block motion search against the previous observation. Recently used moves are tried first. Only
// blocks that none of them explains are searched, and only a few of each observation.
// Threads: compatible (one thread at a time).
class MotionSearch {
 public:
  // Search range, in rows and in columns.
  static constexpr int32_t kReach = 8;
  // Number of moves remembered.
  static constexpr size_t kMoveCount = 3;
  // Maximum failed searches per observation.
  static constexpr int32_t kVainSearchCountMax = 4;

  // Begins the next observation.
  void BeginObservation() { searches_left_ = kVainSearchCountMax; }

  // Returns the move that explains most of `block` of `now`, which differs from `before` at its own
  // place.
  Move Find(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
            const Block& block);

 private:
  // Moves a move to the front.
  void Remember(Move move);

  std::array<Move, kMoveCount> moves_ = {};  // most recent first
  size_t move_count_ = 0;
  int32_t searches_left_ = 0;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_MOTION_SEARCH_H_
