#ifndef SERVER_WIRE_RESPONSE_LIMIT_H_
#define SERVER_WIRE_RESPONSE_LIMIT_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/session/quota/limits.h"

namespace procgen {

// The largest response to send, in bytes, to a client that asked for `asked` in `field`; 0: the
// default. Errors: INVALID_ARGUMENT fewer than kMessageBytesMin; RESOURCE_EXHAUSTED more than the
// limit.
absl::StatusOr<int64_t> ResponseBytesMax(absl::string_view field, int64_t asked,
                                         const Limits& limits);

}  // namespace procgen

#endif  // SERVER_WIRE_RESPONSE_LIMIT_H_
