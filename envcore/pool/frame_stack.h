#ifndef ENVCORE_POOL_FRAME_STACK_H_
#define ENVCORE_POOL_FRAME_STACK_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace procgen {

// The last frames of one environment, for observations that stack frames. The constructor allocates
// all memory. Threads: compatible (one thread at a time).
class FrameStack {
 public:
  // `depth`: frames per observation. REQUIRES: both are at least 1.
  FrameStack(size_t frame_bytes, int32_t depth);

  // Whether the stack holds no frame.
  bool empty() const { return held_ == 0; }
  // Drops all frames. Used when an episode begins or a state is restored.
  void Clear() { held_ = 0; }
  // Returns the memory for the next frame, uint8 [frame_bytes], and counts it as held. A full stack
  // overwrites its oldest frame.
  absl::Span<uint8_t> Next();
  // Writes all frames, oldest first, to `observation`, uint8 [depth, frame_bytes]. The oldest frame
  // fills the places of missing frames. REQUIRES: !empty(); `observation` has that size.
  void CopyTo(absl::Span<uint8_t> observation) const;

 private:
  size_t frame_bytes_;
  size_t depth_;
  std::vector<uint8_t> frames_;  // [depth, frame_bytes], a ring buffer
  size_t next_ = 0;              // index of the next frame
  size_t held_ = 0;              // number of frames, the newest at next_ - 1
};

}  // namespace procgen

#endif  // ENVCORE_POOL_FRAME_STACK_H_
