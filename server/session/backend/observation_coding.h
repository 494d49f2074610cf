#ifndef SERVER_SESSION_BACKEND_OBSERVATION_CODING_H_
#define SERVER_SESSION_BACKEND_OBSERVATION_CODING_H_

#include <cstdint>
#include <memory>

#include "envcore/pool/pool.h"
#include "server/encoding/encoding.h"
#include "server/encoding/observation_encoder.h"

namespace procgen {

// An observation of this format as the encoder sees it.
PictureShape ShapeOf(const ObservationFormat& format);

// How the observations of a pool are sent, and what they take.
class ObservationCoding {
 public:
  explicit ObservationCoding(const ObservationFormat& format, Encoding encoding = Encoding::kRaw);

  Encoding encoding() const { return encoding_; }
  // Bytes of one observation as it is drawn.
  int64_t drawn_bytes() const { return drawn_bytes_; }
  // Bytes that one takes at most as it is sent; several together take no more than so many times
  // that.
  int64_t sent_bytes_max() const { return sent_bytes_max_; }
  // Encodes the observations of a pool for one stream, from its beginning on; null: they are sent
  // as they are drawn.
  std::unique_ptr<ObservationEncoder> MakeEncoder(int32_t env_count) const;

 private:
  Encoding encoding_;
  PictureShape shape_;
  int64_t drawn_bytes_ = 0;
  int64_t sent_bytes_max_ = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_OBSERVATION_CODING_H_
