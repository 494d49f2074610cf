#ifndef PROCGEN_CLIENT_INTERNAL_FRAME_CONTENT_H_
#define PROCGEN_CLIENT_INTERNAL_FRAME_CONTENT_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen_client {

// Decompresses one zstd frame from an untrusted source; allocates at most `content_bytes_max`.
// Errors: DATA_LOSS not exactly one frame, a frame without content size, or larger content.
absl::StatusOr<std::string> FrameContent(absl::string_view frame, size_t content_bytes_max);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_FRAME_CONTENT_H_
