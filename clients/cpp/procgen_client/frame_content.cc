#include "procgen_client/frame_content.h"

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "zstd.h"

namespace procgen_client {
namespace {

absl::Status TooLarge(uint64_t content_bytes, size_t content_bytes_max) {
  return absl::DataLossError(absl::StrCat("encoded observations: content of ", content_bytes,
                                          " bytes, there can be ", content_bytes_max, " at most"));
}

absl::Status NoFrame(absl::string_view reason) {
  return absl::DataLossError(
      absl::StrCat("encoded observations: not one whole frame of zstd: ", reason));
}

}  // namespace

absl::StatusOr<std::string> FrameContent(absl::string_view frame, size_t content_bytes_max) {
  const uint64_t size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) {
    return NoFrame("no header that tells the size of the content");
  }
  if (size > content_bytes_max) {
    return TooLarge(size, content_bytes_max);
  }
  const size_t frame_bytes = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(frame_bytes) != 0 || frame_bytes != frame.size()) {
    return NoFrame("it ends elsewhere");
  }
  std::string content(size, '\0');
  const size_t written = ZSTD_decompress(content.data(), size, frame.data(), frame.size());
  if (ZSTD_isError(written) != 0) {
    return NoFrame(ZSTD_getErrorName(written));
  }
  if (written != size) {
    return NoFrame("the header tells another size");
  }
  return content;
}

}  // namespace procgen_client
