#ifndef PROCGEN_CLIENT_OBSERVATION_DECODER_H_
#define PROCGEN_CLIENT_OBSERVATION_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen_client {

// Decodes the observations of one stream with ENCODING_DELTA_ZSTD; procgen.v1.Encoding defines the
// bytes. All of them must be decoded, once and in order. Memory: one observation of each
// environment. Threads: compatible (one thread at a time).
class ObservationDecoder {
 public:
  // `observation_bytes`: F, of one observation.
  ObservationDecoder(int32_t env_count, size_t observation_bytes)
      : observation_bytes_(observation_bytes),
        received_(static_cast<size_t>(env_count) * observation_bytes) {}

  // Decodes the observations of the environments [first, first + count) into `observations`
  // [count, F]. REQUIRES: environments of the pool, and that size. Errors: DATA_LOSS malformed
  // bytes, or of another size; the content of `observations` is undefined then.
  absl::Status Decode(int32_t first, int32_t count, absl::string_view encoded,
                      absl::Span<uint8_t> observations);

 private:
  size_t observation_bytes_;
  std::vector<uint8_t> received_;  // [N, F]; zeros before the first
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_OBSERVATION_DECODER_H_
