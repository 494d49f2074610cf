#ifndef PROCGEN_CLIENT_FRAME_CONTENT_H_
#define PROCGEN_CLIENT_FRAME_CONTENT_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "procgen/v1/pools.pb.h"

namespace procgen_client {

// The content of one frame of zstd (ENCODING_ZSTD_DIFFERENCE) or LZ4 (ENCODING_LZ4_DIFFERENCE),
// whatever bytes are given: no more than content_bytes_max is ever held. Errors: DATA_LOSS not one
// whole frame, or one whose header does not tell the size of its content; INVALID_ARGUMENT another
// encoding.
absl::StatusOr<std::string> FrameContent(procgen::v1::Encoding encoding, absl::string_view frame,
                                         size_t content_bytes_max);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_FRAME_CONTENT_H_
