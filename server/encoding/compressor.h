#ifndef SERVER_ENCODING_COMPRESSOR_H_
#define SERVER_ENCODING_COMPRESSOR_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/types/span.h"
#include "zstd.h"

namespace procgen {

// Writes zstd frames (RFC 8878) with a checksum and the content size in the header. Ends the
// process if it runs out of memory. Threads: compatible (one thread at a time).
class Compressor {
 public:
  Compressor();

  // Maximum bytes of a frame with so much content. A frame of n times the content takes at most n
  // times that.
  static size_t FrameBytesMax(size_t content_bytes);
  // Compresses `numbers` and then `pixels` into one frame, with a block boundary between them:
  // their statistics differ.
  std::string Compress(absl::Span<const uint8_t> numbers, absl::Span<const uint8_t> pixels);

 private:
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };

  void Write(absl::Span<const uint8_t> bytes, ZSTD_EndDirective end, ZSTD_outBuffer& output);

  std::unique_ptr<ZSTD_CCtx, Free> context_;
};

}  // namespace procgen

#endif  // SERVER_ENCODING_COMPRESSOR_H_
