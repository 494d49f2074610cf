#ifndef ENVCORE_POOL_FRAME_STACK_H_
#define ENVCORE_POOL_FRAME_STACK_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// The last frames of one environment, as many as an observation shows. All memory is taken when it
// is made. Threads: compatible (one thread at a time).
class FrameStack {
 public:
  // Of `depth` frames of `frame_bytes` bytes. REQUIRES: both are at least 1.
  FrameStack(size_t frame_bytes, int32_t depth);

  // Whether no frame is held.
  bool empty() const { return held_ == 0; }
  // Forgets all frames: an episode begins, or a state was restored.
  void Clear() { held_ = 0; }
  // Where the next frame, uint8 [frame_bytes], is to be written; it counts as held. Of a full stack
  // it takes the place of the oldest.
  absl::Span<uint8_t> Next();
  // Writes all frames, oldest first, to `observation`, uint8 [depth, frame_bytes]. Where fewer are
  // held, the oldest stands in the missing places. REQUIRES: !empty(), and `observation` has that
  // size.
  void CopyTo(absl::Span<uint8_t> observation) const;

 private:
  size_t frame_bytes_;
  size_t depth_;
  std::vector<uint8_t> frames_;  // [depth, frame_bytes], a ring
  size_t next_ = 0;              // the place of the next frame
  size_t held_ = 0;              // frames, the last of them before next_
};

}  // namespace procgen

#endif  // ENVCORE_POOL_FRAME_STACK_H_
