#ifndef SERVER_SESSION_BACKEND_OBSERVATION_CODING_H_
#define SERVER_SESSION_BACKEND_OBSERVATION_CODING_H_

#include <cstdint>
#include <memory>

#include "envcore/pool/pool.h"
#include "server/encoding/encoding.h"
#include "server/encoding/observation_encoder.h"

namespace procgen {

// The encoder's description of an observation in `format`.
PictureShape ShapeOf(const ObservationFormat& format);

// The encoding of a pool's observations, and their size in bytes.
class ObservationCoding {
 public:
  explicit ObservationCoding(const ObservationFormat& format, Encoding encoding = Encoding::kRaw);

  Encoding encoding() const { return encoding_; }
  // Bytes of one observation as drawn, before encoding.
  int64_t drawn_bytes() const { return drawn_bytes_; }
  // Maximum bytes of one encoded observation. N observations take at most N times this.
  int64_t sent_bytes_max() const { return sent_bytes_max_; }
  // Returns a new encoder for one stream. Null if observations are sent as drawn.
  std::unique_ptr<ObservationEncoder> MakeEncoder(int32_t env_count) const;

 private:
  Encoding encoding_;
  PictureShape shape_;
  int64_t drawn_bytes_ = 0;
  int64_t sent_bytes_max_ = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_OBSERVATION_CODING_H_
