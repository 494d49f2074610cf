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

// Decodes the observations of a pool whose encoding is not ENCODING_RAW; the comment of
// procgen.v1.Encoding defines the bytes. It needs all encoded observations of a learner's answers,
// each once, in the order of their sequence numbers, and remembers each environment's last one.
// F: the bytes of one observation, Pool.observation_bytes.
// Threads: compatible (one thread at a time).
class ObservationDecoder {
 public:
  // For a pool as the server told it. Errors: INVALID_ARGUMENT an encoding or an observation format
  // that is not known here.
  static absl::StatusOr<ObservationDecoder> Make(const procgen::v1::Pool& pool);

  int32_t env_count() const { return env_count_; }
  // Bytes of one observation, F.
  size_t observation_bytes() const { return sheet_.bytes(); }

  // Decodes the observations of the environments [first, first + count) into `observations`
  // [count, F]. Errors: INVALID_ARGUMENT environments that the pool has not, or room of another
  // size; DATA_LOSS the bytes are no such observations; FAILED_PRECONDITION they follow others than
  // were decoded last, so some are missing or came twice. After an error nothing has changed, but
  // what was written to `observations` has no meaning.
  absl::Status Decode(int32_t first, int32_t count, absl::string_view encoded,
                      absl::Span<uint8_t> observations);

 private:
  // The sheet that an observation is here: `rows` rows of `columns` pixels.
  struct Sheet {
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

  ObservationDecoder(const Sheet& sheet, int32_t env_count);

  int32_t block_columns() const;
  int32_t block_count() const;
  Block BlockAt(int32_t index) const;
  size_t ContentBytesMax(int32_t count) const;

  // Finds the parts of the content and checks that they fit together and to what was decoded.
  absl::StatusOr<Content> Read(int32_t first, int32_t count, absl::string_view bytes) const;
  absl::Status CheckAges(int32_t first, const Content& content) const;
  absl::Status CheckBlocks(int32_t count, Content& content) const;
  // Writes what the observation follows from, before its blocks are changed.
  void WriteBasis(size_t environment, int32_t age, int32_t advance, uint8_t* basis) const;
  // Copies pixels from `column` of a row of the sheet on; beyond its ends those of the ends go on.
  void CopyPixels(const uint8_t* row, int32_t column, int32_t width, uint8_t* to) const;
  void DecodeBlock(const uint8_t* basis, const Block& block, Content& content,
                   uint8_t* observation) const;

  Sheet sheet_;
  int32_t env_count_;
  // Of the environments up to the last one that was decoded, so that memory follows what a server
  // sends and not what it says of its pool.
  std::vector<uint8_t> ages_;   // [..N] that is next; 0: only an observation without a past
  std::vector<uint8_t> shown_;  // [..N, F]
  std::vector<uint8_t> basis_;  // [F] of the observation that is being decoded
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_OBSERVATION_DECODER_H_
