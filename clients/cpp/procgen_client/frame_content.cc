#include "procgen_client/frame_content.h"

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "lz4frame.h"
#include "zstd.h"

namespace procgen_client {
namespace {

absl::Status TooLarge(uint64_t content_bytes, size_t content_bytes_max) {
  return absl::DataLossError(absl::StrCat("encoded observations: content of ", content_bytes,
                                          " bytes, there can be ", content_bytes_max, " at most"));
}

absl::Status NoFrame(absl::string_view format, absl::string_view reason) {
  return absl::DataLossError(
      absl::StrCat("encoded observations: not one whole frame of ", format, ": ", reason));
}

absl::StatusOr<std::string> ZstdContent(absl::string_view frame, size_t content_bytes_max) {
  const uint64_t size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) {
    return NoFrame("zstd", "no header that tells the size of the content");
  }
  if (size > content_bytes_max) {
    return TooLarge(size, content_bytes_max);
  }
  const size_t frame_bytes = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(frame_bytes) != 0 || frame_bytes != frame.size()) {
    return NoFrame("zstd", "it ends elsewhere");
  }
  std::string content(size, '\0');
  const size_t written = ZSTD_decompress(content.data(), size, frame.data(), frame.size());
  if (ZSTD_isError(written) != 0) {
    return NoFrame("zstd", ZSTD_getErrorName(written));
  }
  if (written != size) {
    return NoFrame("zstd", "the header tells another size");
  }
  return content;
}

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

absl::StatusOr<std::string> Lz4Content(absl::string_view frame, size_t content_bytes_max) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) {
    return absl::ResourceExhaustedError("no memory for LZ4");
  }
  const std::unique_ptr<LZ4F_dctx, FreeLz4> context(made);
  LZ4F_frameInfo_t info = LZ4F_INIT_FRAMEINFO;
  size_t header = frame.size();
  const size_t hint = LZ4F_getFrameInfo(context.get(), &info, frame.data(), &header);
  if (LZ4F_isError(hint) != 0) {
    return NoFrame("LZ4", LZ4F_getErrorName(hint));
  }
  if (info.frameType != LZ4F_frame || info.contentSize == 0) {
    return NoFrame("LZ4", "no header that tells the size of the content");
  }
  if (info.contentSize > content_bytes_max) {
    return TooLarge(info.contentSize, content_bytes_max);
  }
  std::string content(info.contentSize, '\0');
  size_t written = content.size();
  size_t read = frame.size() - header;
  const size_t left = LZ4F_decompress(context.get(), content.data(), &written,
                                      frame.data() + header, &read, nullptr);
  if (LZ4F_isError(left) != 0) {
    return NoFrame("LZ4", LZ4F_getErrorName(left));
  }
  if (left != 0 || header + read != frame.size() || written != content.size()) {
    return NoFrame("LZ4", "it ends elsewhere");
  }
  return content;
}

}  // namespace

absl::StatusOr<std::string> FrameContent(procgen::v1::Encoding encoding, absl::string_view frame,
                                         size_t content_bytes_max) {
  switch (encoding) {
    case procgen::v1::ENCODING_ZSTD_DIFFERENCE:
      return ZstdContent(frame, content_bytes_max);
    case procgen::v1::ENCODING_LZ4_DIFFERENCE:
      return Lz4Content(frame, content_bytes_max);
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("encoding is ", static_cast<int>(encoding),
                       "; decoded are ENCODING_ZSTD_DIFFERENCE and ENCODING_LZ4_DIFFERENCE"));
  }
}

}  // namespace procgen_client
