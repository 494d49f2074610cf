#include "server/duration_flag.h"

namespace procgen {

bool AbslParseFlag(absl::string_view text, DurationFlag* flag, std::string* error) {
  if (!absl::ParseDuration(text, &flag->value)) {
    *error = "allowed: a duration with its unit, such as 10s, 500ms or 1h30m";
    return false;
  }
  return true;
}

std::string AbslUnparseFlag(DurationFlag flag) { return absl::FormatDuration(flag.value); }

}  // namespace procgen
