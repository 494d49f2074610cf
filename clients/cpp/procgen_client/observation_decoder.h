#ifndef PROCGEN_CLIENT_OBSERVATION_DECODER_H_
#define PROCGEN_CLIENT_OBSERVATION_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "procgen/v1/pools.pb.h"

namespace procgen_client {

// Decodes the observations of a pool with ENCODING_DELTA_ZSTD; procgen.v1.Encoding defines the
// bytes. Observations must be decoded once each, in the order of sequence numbers, without gaps.
// The decoder keeps the last observation of each environment. F: the bytes of one observation,
// Pool.observation_bytes. Threads: compatible (one thread at a time).
class ObservationDecoder {
 public:
  // Creates a decoder for a pool. Errors: INVALID_ARGUMENT an unknown encoding or observation
  // format.
  static absl::StatusOr<ObservationDecoder> Make(const procgen::v1::Pool& pool);

  int32_t env_count() const { return env_count_; }
  // Bytes of one observation, F.
  size_t observation_bytes() const { return plane_.bytes(); }

  // Decodes the observations of the environments [first, first + count) into `observations`
  // [count, F]. Errors: INVALID_ARGUMENT environments out of range, or `observations` has the wrong
  // size; DATA_LOSS malformed bytes; FAILED_PRECONDITION a gap: earlier observations are missing or
  // these were decoded before. After an error the decoder is unchanged, and the content of
  // `observations` is undefined.
  absl::Status Decode(int32_t first, int32_t count, absl::string_view encoded,
                      absl::Span<uint8_t> observations);

 private:
  // An observation as the codec's plane: `rows` rows of `columns` pixels.
  struct Plane {
    int32_t rows = 0;
    int32_t columns = 0;
    int32_t pixel_bytes = 0;
    int32_t stack = 1;

    size_t row_bytes() const {
      return static_cast<size_t>(columns) * static_cast<size_t>(pixel_bytes);
    }
    size_t bytes() const { return static_cast<size_t>(rows) * row_bytes(); }
  };
  struct Content;
  struct Block;

  ObservationDecoder(const Plane& plane, int32_t env_count);

  int32_t block_columns() const;
  int32_t block_count() const;
  Block BlockAt(int32_t index) const;
  size_t ContentBytesMax(int32_t count) const;

  // Splits the content into its tables and validates them, also against what was decoded before.
  absl::StatusOr<Content> Read(int32_t first, int32_t count, absl::string_view bytes) const;
  absl::Status CheckAges(int32_t first, const Content& content) const;
  absl::Status CheckBlocks(int32_t count, Content& content) const;
  // Writes the observation that the delta refers to.
  void WriteBasis(size_t environment, int32_t age, int32_t advance, uint8_t* basis) const;
  // Copies `width` pixels of a row of the plane from `column` on; columns outside are clamped.
  void CopyPixels(const uint8_t* row, int32_t column, int32_t width, uint8_t* to) const;
  void DecodeBlock(const uint8_t* basis, const Block& block, Content& content,
                   uint8_t* observation) const;

  Plane plane_;
  int32_t env_count_;
  // Grown to the highest environment that was decoded, so that memory follows the bytes received
  // and not the size that the server states.
  std::vector<uint8_t> ages_;   // [..N] the next age; 0: only a key frame may follow
  std::vector<uint8_t> shown_;  // [..N, F] the last observation
  std::vector<uint8_t> basis_;  // [F] scratch: the observation that the delta refers to
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_OBSERVATION_DECODER_H_
