#include "server/encoding/compressor.h"

#include "lz4frame.h"
#include "server/encoding/check.h"
#include "zstd.h"

namespace procgen {
namespace {

// More effort makes one byte in twenty less and takes twice as long (README.md).
constexpr int kZstdLevel = 1;

size_t NoZstdError(size_t result) {
  Check(ZSTD_isError(result) == 0, "zstd cannot compress");
  return result;
}

size_t NoLz4Error(size_t result) {
  Check(LZ4F_isError(result) == 0, "LZ4 cannot compress");
  return result;
}

class ZstdCompressor final : public Compressor {
 public:
  ZstdCompressor() : context_(ZSTD_createCCtx()) {
    Check(context_ != nullptr, "no memory for zstd");
    NoZstdError(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kZstdLevel));
    NoZstdError(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1));
  }

  // Ending a block early takes a header more; the checksum counts, too.
  static size_t BytesMax(size_t content_bytes) {
    return ZSTD_compressBound(content_bytes) + kBlockHeaderBytes + kChecksumBytes;
  }

  std::string Compress(absl::Span<const uint8_t> numbers,
                       absl::Span<const uint8_t> pixels) override {
    const size_t size = numbers.size() + pixels.size();
    std::string frame(BytesMax(size), '\0');
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

 private:
  static constexpr size_t kBlockHeaderBytes = 3;
  static constexpr size_t kChecksumBytes = 4;
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };

  void Write(absl::Span<const uint8_t> bytes, ZSTD_EndDirective end, ZSTD_outBuffer& output) {
    ZSTD_inBuffer input = {bytes.data(), bytes.size(), 0};
    const size_t left = NoZstdError(ZSTD_compressStream2(context_.get(), &output, &input, end));
    Check(left == 0, "a frame of zstd is larger than its bound");
  }

  std::unique_ptr<ZSTD_CCtx, Free> context_;
};

class Lz4Compressor final : public Compressor {
 public:
  Lz4Compressor() {
    LZ4F_cctx* context = nullptr;
    NoLz4Error(LZ4F_createCompressionContext(&context, LZ4F_VERSION));
    context_.reset(context);
  }

  // Numbers and pixels end blocks of their own.
  static size_t BytesMax(size_t content_bytes) {
    const LZ4F_preferences_t preferences = Preferences();
    return LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(content_bytes, &preferences) +
           LZ4F_compressBound(0, &preferences);
  }

  std::string Compress(absl::Span<const uint8_t> numbers,
                       absl::Span<const uint8_t> pixels) override {
    const size_t size = numbers.size() + pixels.size();
    std::string frame(BytesMax(size), '\0');
    preferences_.frameInfo.contentSize = size;
    size_t end =
        NoLz4Error(LZ4F_compressBegin(context_.get(), frame.data(), frame.size(), &preferences_));
    for (const absl::Span<const uint8_t> bytes : {numbers, pixels}) {
      end += NoLz4Error(LZ4F_compressUpdate(context_.get(), frame.data() + end, frame.size() - end,
                                            bytes.data(), bytes.size(), nullptr));
    }
    end += NoLz4Error(
        LZ4F_compressEnd(context_.get(), frame.data() + end, frame.size() - end, nullptr));
    frame.resize(end);
    return frame;
  }

 private:
  struct Free {
    void operator()(LZ4F_cctx* context) const { LZ4F_freeCompressionContext(context); }
  };

  static LZ4F_preferences_t Preferences() {
    LZ4F_preferences_t preferences = LZ4F_INIT_PREFERENCES;
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    preferences.autoFlush = 1;
    return preferences;
  }

  std::unique_ptr<LZ4F_cctx, Free> context_;
  LZ4F_preferences_t preferences_ = Preferences();
};

}  // namespace

size_t Compressor::FrameBytesMax(Compression compression, size_t content_bytes) {
  return compression == Compression::kZstd ? ZstdCompressor::BytesMax(content_bytes)
                                           : Lz4Compressor::BytesMax(content_bytes);
}

std::unique_ptr<Compressor> Compressor::Make(Compression compression) {
  if (compression == Compression::kZstd) {
    return std::make_unique<ZstdCompressor>();
  }
  return std::make_unique<Lz4Compressor>();
}

}  // namespace procgen
