#include "procgen_client/internal/frame_content.h"

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "zstd.h"

namespace procgen_client {
namespace {

absl::Status TooLarge(uint64_t content_bytes, size_t content_bytes_max) {
  return absl::DataLossError(absl::StrCat("encoded observations: content of ", content_bytes,
                                          " bytes, expected: at most ", content_bytes_max));
}

absl::Status NoFrame(absl::string_view reason) {
  return absl::DataLossError(
      absl::StrCat("encoded observations: not one complete zstd frame: ", reason));
}

}  // namespace

absl::StatusOr<std::string> FrameContent(absl::string_view frame, size_t content_bytes_max) {
  const uint64_t size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) {
    return NoFrame("no header with a content size");
  }
  if (size > content_bytes_max) {
    return TooLarge(size, content_bytes_max);
  }
  const size_t frame_bytes = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(frame_bytes) != 0 || frame_bytes != frame.size()) {
    return NoFrame("its size differs from the size of the bytes");
  }
  std::string content(size, '\0');
  const size_t written = ZSTD_decompress(content.data(), size, frame.data(), frame.size());
  if (ZSTD_isError(written) != 0) {
    return NoFrame(ZSTD_getErrorName(written));
  }
  if (written != size) {
    return NoFrame("its content differs from the size in the header");
  }
  return content;
}

}  // namespace procgen_client
