#ifndef SERVER_ENCODING_OBSERVATION_ENCODER_H_
#define SERVER_ENCODING_OBSERVATION_ENCODER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "server/encoding/compressor.h"
#include "server/encoding/delta.h"
#include "server/encoding/motion_search.h"
#include "server/encoding/picture_shape.h"

namespace procgen {

// Encodes the observations of a pool for one stream, losslessly: each as a delta to the
// environment's previous one. Encoding in proto/procgen/v1/pools.proto defines the bytes.
//
// Only encoded observations are part of the state; steps without observations and final
// observations are not. The decoder must receive all output in order. The first observation of each
// environment is a key frame, so any decoder can read the output of a new encoder.
// Memory: one observation of each environment, plus temporary buffers for the delta of a slice.
// Threads: compatible (one thread at a time).
class ObservationEncoder {
 public:
  // REQUIRES: a shape with sides in [1, 512], at most 3 planes, a stack of at most 16; env_count >
  // 0.
  ObservationEncoder(const PictureShape& shape, int32_t env_count);

  // Maximum bytes of one encoded observation, slightly more than the raw size. N observations
  // encoded together take at most N times this.
  static size_t EncodedBytesMax(const PictureShape& shape);

  // Encodes the observations of environments [first, first + count): [count, F]. REQUIRES:
  // environments of the pool, and that size.
  std::string Encode(int32_t first, int32_t count, absl::Span<const uint8_t> observations);

 private:
  // The learner's state of an environment.
  struct Environment {
    MotionSearch search;
    uint8_t age = 0;  // observations since the key frame
  };

  // Number of frames by which the stack advanced since the last observation.
  int32_t FindAdvance(const uint8_t* before, const uint8_t* now) const;
  // Shifts `before` to the most likely current stack.
  void Advance(int32_t count, uint8_t* before) const;
  void Append(size_t environment, const uint8_t* now);

  const PictureShape shape_;
  std::vector<Environment> environments_;
  std::vector<uint8_t> shown_;  // uint8 [N, F]; zeros before the first
  Compressor compressor_;
  // Of the slice being encoded.
  ByteList ages_;
  ByteList advances_;
  Delta delta_;
  std::vector<uint8_t> numbers_;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_OBSERVATION_ENCODER_H_
