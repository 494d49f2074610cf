#include "envcore/pool/frame_stack.h"

#include <algorithm>

namespace procgen {

FrameStack::FrameStack(size_t frame_bytes, int32_t depth)
    : frame_bytes_(frame_bytes),
      depth_(static_cast<size_t>(depth)),
      frames_(frame_bytes * static_cast<size_t>(depth)) {}

absl::Span<uint8_t> FrameStack::Next() {
  const size_t place = next_;
  next_ = (next_ + 1) % depth_;
  held_ = std::min(held_ + 1, depth_);
  return absl::MakeSpan(frames_).subspan(place * frame_bytes_, frame_bytes_);
}

void FrameStack::CopyTo(absl::Span<uint8_t> observation) const {
  uint8_t* out = observation.data();
  for (size_t age = depth_; age >= 1; --age) {
    const size_t place = (next_ + depth_ - std::min(age, held_)) % depth_;
    out = std::copy_n(frames_.data() + place * frame_bytes_, frame_bytes_, out);
  }
}

}  // namespace procgen
