#ifndef PROCGEN_CLIENT_FRAME_CONTENT_H_
#define PROCGEN_CLIENT_FRAME_CONTENT_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace procgen_client {

// The content of one zstd frame, whatever bytes are given: no more than content_bytes_max is ever
// held. Errors: DATA_LOSS not one whole frame, or one whose header does not give the size of its
// content.
absl::StatusOr<std::string> FrameContent(absl::string_view frame, size_t content_bytes_max);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_FRAME_CONTENT_H_
