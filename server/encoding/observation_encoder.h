#ifndef SERVER_ENCODING_OBSERVATION_ENCODER_H_
#define SERVER_ENCODING_OBSERVATION_ENCODER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "server/encoding/encoding.h"
#include "zstd.h"

namespace procgen {

// Encodes the observations of a pool for one stream, losslessly: each as the difference to the
// environment's previous one, compressed with zstd. Encoding in proto/procgen/v1/pools.proto
// defines the bytes. Only encoded observations count as previous ones.
// Memory: one observation of each environment, and the differences of a slice. Ends the process if
// that runs out. Threads: compatible (one thread at a time).
class ObservationEncoder {
 public:
  // `observation_bytes`: F, of one observation.
  ObservationEncoder(int32_t env_count, size_t observation_bytes);

  // Encodes the observations of environments [first, first + count): [count, F]. REQUIRES:
  // environments of the pool, and that size.
  std::string Encode(int32_t first, int32_t count, absl::Span<const uint8_t> observations);

 private:
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };

  const size_t observation_bytes_;
  std::vector<uint8_t> sent_;         // [N, F]; zeros before the first
  std::vector<uint8_t> differences_;  // of the slice being encoded
  const std::unique_ptr<ZSTD_CCtx, Free> zstd_;
};

// Upper bound of N encoded observations, divided by N, in bytes.
int64_t EncodedBytesMax(Encoding encoding, int64_t observation_bytes);

}  // namespace procgen

#endif  // SERVER_ENCODING_OBSERVATION_ENCODER_H_
