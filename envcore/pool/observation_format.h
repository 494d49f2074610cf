#ifndef ENVCORE_POOL_OBSERVATION_FORMAT_H_
#define ENVCORE_POOL_OBSERVATION_FORMAT_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "envcore/render/output/frame_format.h"

namespace procgen {

// The sides that an observation can be drawn at, in pixels, and how many frames it can show.
inline constexpr int32_t kObservationSizePxMin = 16;
inline constexpr int32_t kObservationSizePxMax = 512;
inline constexpr int32_t kFrameStackMax = 16;

// The form of a pool's observations. By default that of Procgen 0.10.7: uint8 [64, 64, 3], top row
// first, red, green, blue.
struct ObservationFormat {
  FrameFormat frame;
  // How many frames of successive steps one observation shows, oldest first. Where an episode is
  // younger than that, and after a state was restored, the first frame stands in the missing
  // places.
  int32_t frame_stack = 1;

  // Bytes of one observation.
  size_t bytes() const { return frame.bytes() * static_cast<size_t>(frame_stack); }
  // Its shape, row-major: the frame's; for a stack of k > 1 frames with k before it, so
  // [k, side, side, channels] or [k, channels, side, side].
  std::vector<int32_t> Shape() const;
  bool operator==(const ObservationFormat&) const = default;
};

// Errors: INVALID_ARGUMENT a value out of range (the message names it and the range).
absl::Status CheckObservationFormat(const ObservationFormat& format);

}  // namespace procgen

#endif  // ENVCORE_POOL_OBSERVATION_FORMAT_H_
