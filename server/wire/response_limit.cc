#include "server/wire/response_limit.h"

#include <algorithm>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace procgen {

absl::StatusOr<int64_t> ResponseBytesMax(absl::string_view field, int64_t asked,
                                         const Limits& limits) {
  if (asked == 0) {
    return std::min(kResponseBytesDefault, limits.response_bytes_max);
  }
  if (asked < kMessageBytesMin) {
    return absl::InvalidArgumentError(absl::StrCat(field, " is ", asked, ", allowed: 0, or ",
                                                   kMessageBytesMin, " to ",
                                                   limits.response_bytes_max));
  }
  if (asked > limits.response_bytes_max) {
    return absl::ResourceExhaustedError(absl::StrCat(
        field, " is ", asked, ", limit response_bytes_max is ", limits.response_bytes_max));
  }
  return asked;
}

}  // namespace procgen
