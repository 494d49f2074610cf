#ifndef ENVCORE_POOL_OBSERVATION_FORMAT_H_
#define ENVCORE_POOL_OBSERVATION_FORMAT_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "envcore/render/output/frame_format.h"
#include "envcore/status/status.h"

namespace procgen {

// Range of the size of an observation in pixels, and the largest frame stack.
inline constexpr int32_t kObservationSizePxMin = 16;
inline constexpr int32_t kObservationSizePxMax = 512;
inline constexpr int32_t kFrameStackMax = 16;

// The format of a pool's observations. The default is that of Procgen 0.10.7: uint8 [64, 64, 3],
// top row first, RGB.
struct ObservationFormat {
  FrameFormat frame;
  // Number of successive frames in one observation, oldest first, in [1, kFrameStackMax]. At the
  // start of an episode and after a restore, the first frame fills the missing places.
  int32_t frame_stack = 1;

  // Bytes of one observation.
  size_t bytes() const { return frame.bytes() * static_cast<size_t>(frame_stack); }
  // The shape, row-major: that of the frame, preceded by k for a stack of k > 1 frames. So
  // [size_px, size_px, channels] or [channels, size_px, size_px], or k before either.
  std::vector<int32_t> Shape() const;
  bool operator==(const ObservationFormat&) const = default;
};

// Errors: INVALID_ARGUMENT: a value is out of range (the message gives the value and the range).
Status CheckObservationFormat(const ObservationFormat& format);

}  // namespace procgen

#endif  // ENVCORE_POOL_OBSERVATION_FORMAT_H_
