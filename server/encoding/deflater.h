#ifndef SERVER_ENCODING_DEFLATER_H_
#define SERVER_ENCODING_DEFLATER_H_

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/types/span.h"

namespace procgen {

// Compresses with raw deflate (RFC 1951) relative to a dictionary, which the reader has, too. Ends
// the process if it runs out of memory. Threads: compatible (one thread at a time).
class Deflater {
 public:
  // Sum of the sizes of a dictionary and of the bytes relative to it at which all of both are
  // within reach of a match.
  static constexpr size_t kReachBytes = 32 << 10;

  Deflater();
  ~Deflater();
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  // Returns whole blocks, of which none is marked as the last one, and which end with a byte. So a
  // reader without preset dictionaries can precede them by the dictionary as a stored block.
  std::string Deflate(absl::Span<const uint8_t> bytes, absl::Span<const uint8_t> dictionary);

 private:
  z_stream stream_ = {};
};

}  // namespace procgen

#endif  // SERVER_ENCODING_DEFLATER_H_
