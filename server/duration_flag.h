#ifndef SERVER_DURATION_FLAG_H_
#define SERVER_DURATION_FLAG_H_

#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace procgen {

// The type of a flag that is a duration. Its syntax is that of absl::Duration, whose own parser
// reports no reason for an error.
struct DurationFlag {
  absl::Duration value;
};

// For Abseil. Errors: `error` is what is allowed.
bool AbslParseFlag(absl::string_view text, DurationFlag* flag, std::string* error);
std::string AbslUnparseFlag(DurationFlag flag);

}  // namespace procgen

#endif  // SERVER_DURATION_FLAG_H_
