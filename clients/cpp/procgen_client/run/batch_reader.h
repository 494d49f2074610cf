#ifndef PROCGEN_CLIENT_RUN_BATCH_READER_H_
#define PROCGEN_CLIENT_RUN_BATCH_READER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "envcore/pool/pool.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen_client/observation_decoder.h"

namespace procgen_client {

// What a batch must contain.
struct BatchShape {
  int32_t first = 0;  // environment of row 0
  int32_t count = 0;  // rows
  size_t observation_bytes = 0;
};

// Reads the responses of RunPool that contain a batch, directly into the caller's memory.
// Threads: compatible.
class BatchReader {
 public:
  // Parses `response` into the arrays of `batch`, each with a row for each environment; all
  // but terminated, truncated and fingerprints may be empty. Rows without an episode's end have
  // fingerprint 0 and keep their final observation. `decoder`: for encoded observations; null: they
  // are raw. Errors: DATA_LOSS the response is malformed or does not fit `shape`; those of the
  // decoder. Then the arrays' contents are undefined, but nothing beyond them was written.
  absl::Status Read(grpc::ByteBuffer response, const BatchShape& shape, const procgen::Batch& batch,
                    ObservationDecoder* decoder);

 private:
  std::vector<uint64_t> fingerprints_;
  std::vector<uint8_t> finals_;
  std::string encoded_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_RUN_BATCH_READER_H_
