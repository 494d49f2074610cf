#include "server/encoding/compressor.h"

#include "server/encoding/check.h"

namespace procgen {
namespace {

// Higher levels save one byte in twenty and take twice as long (README.md).
constexpr int kZstdLevel = 1;
// An early block end adds a header; the checksum counts, too.
constexpr size_t kBlockHeaderBytes = 3;
constexpr size_t kChecksumBytes = 4;

size_t NoZstdError(size_t result) {
  Check(ZSTD_isError(result) == 0, "zstd cannot compress");
  return result;
}

}  // namespace

Compressor::Compressor() : context_(ZSTD_createCCtx()) {
  Check(context_ != nullptr, "no memory for zstd");
  NoZstdError(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kZstdLevel));
  NoZstdError(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1));
}

size_t Compressor::FrameBytesMax(size_t content_bytes) {
  return ZSTD_compressBound(content_bytes) + kBlockHeaderBytes + kChecksumBytes;
}

std::string Compressor::Compress(absl::Span<const uint8_t> numbers,
                                 absl::Span<const uint8_t> pixels) {
  const size_t size = numbers.size() + pixels.size();
  std::string frame(FrameBytesMax(size), '\0');
  NoZstdError(ZSTD_CCtx_reset(context_.get(), ZSTD_reset_session_only));
  NoZstdError(ZSTD_CCtx_setPledgedSrcSize(context_.get(), size));
  ZSTD_outBuffer output = {frame.data(), frame.size(), 0};
  Write(numbers, pixels.empty() ? ZSTD_e_end : ZSTD_e_flush, output);
  if (!pixels.empty()) {
    Write(pixels, ZSTD_e_end, output);
  }
  frame.resize(output.pos);
  return frame;
}

void Compressor::Write(absl::Span<const uint8_t> bytes, ZSTD_EndDirective end,
                       ZSTD_outBuffer& output) {
  ZSTD_inBuffer input = {bytes.data(), bytes.size(), 0};
  const size_t left = NoZstdError(ZSTD_compressStream2(context_.get(), &output, &input, end));
  Check(left == 0, "a frame of zstd is larger than its bound");
}

}  // namespace procgen
