#ifndef SERVER_ENCODING_COMPRESSOR_H_
#define SERVER_ENCODING_COMPRESSOR_H_

#include <cstddef>
#include <memory>
#include <string>

#include "absl/types/span.h"

namespace procgen {

// What the last stage of an encoding is done by.
enum class Compression { kZstd, kLz4 };

// Writes one frame of zstd or LZ4, in the format that its tools read, with the size of its content
// in the header. What does not fit in memory, or a bug of the library, ends the process. Threads:
// compatible (one thread at a time).
class Compressor {
 public:
  static std::unique_ptr<Compressor> Make(Compression compression);
  virtual ~Compressor() = default;

  // The most bytes that a frame of so much content takes. One of n times the content takes no more
  // than n times that.
  static size_t FrameBytesMax(Compression compression, size_t content_bytes);
  // Compresses `numbers` and then `pixels` into one frame. Where the two meet a new block of the
  // format may begin: they are bytes of different kinds.
  virtual std::string Compress(absl::Span<const uint8_t> numbers,
                               absl::Span<const uint8_t> pixels) = 0;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_COMPRESSOR_H_
