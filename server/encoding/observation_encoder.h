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

// Encodes the observations of a pool for one learner: what each environment shows by what it showed
// in the answer before (Encoding in proto/procgen/v1/pools.proto defines the bytes). Lossless.
//
// Only what is encoded counts as shown: steps whose pictures nobody asked for are no part of it,
// nor are final observations. What was encoded must reach the decoder in the same order, all of it.
// The first observation of each environment is told without its past, so that a new encoder makes a
// new beginning: what it writes is understood by any decoder, whatever that has seen before.
// Memory: one observation of each environment, and for a while what a slice differs in.
// Threads: compatible (one thread at a time).
class ObservationEncoder {
 public:
  // REQUIRES: a shape whose sides are in [1, 512], three rows of planes and 16 pictures counted
  // once each; env_count > 0.
  ObservationEncoder(const PictureShape& shape, int32_t env_count);

  // What an observation takes at most, some more bytes than it has: however many are encoded
  // together, they take no more than so many times this.
  static size_t EncodedBytesMax(const PictureShape& shape);

  // Encodes the observations of the environments [first, first + count): [count, F].
  // REQUIRES: environments of the pool, and so many bytes.
  std::string Encode(int32_t first, int32_t count, absl::Span<const uint8_t> observations);

 private:
  // What the learner has of an environment.
  struct Environment {
    MotionSearch search;
    uint8_t age = 0;  // observations since the first, which is told without a past
  };

  // How many pictures of the stack went out at its front since it was last shown.
  int32_t FindAdvance(const uint8_t* before, const uint8_t* now) const;
  // Makes `before` the stack that it is likely to be now.
  void Advance(int32_t count, uint8_t* before) const;
  void Append(size_t environment, const uint8_t* now);

  const PictureShape shape_;
  std::vector<Environment> environments_;
  std::vector<uint8_t> shown_;  // uint8 [N, F]; zeros where nothing was shown
  Compressor compressor_;
  // Of the slice that is being encoded.
  ByteList ages_;
  ByteList advances_;
  Delta delta_;
  std::vector<uint8_t> numbers_;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_OBSERVATION_ENCODER_H_
