#ifndef SERVER_WIRE_RESPONSE_LIMIT_H_
#define SERVER_WIRE_RESPONSE_LIMIT_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/session/quota/limits.h"

namespace procgen {

// Returns the largest size of a response to a client that requested `asked` in `field`, in bytes. 0
// requests the default. Errors: INVALID_ARGUMENT less than kMessageBytesMin; RESOURCE_EXHAUSTED
// more than the limit.
absl::StatusOr<int64_t> ResponseBytesMax(absl::string_view field, int64_t asked,
                                         const Limits& limits);

}  // namespace procgen

#endif  // SERVER_WIRE_RESPONSE_LIMIT_H_
