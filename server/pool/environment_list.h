#ifndef SERVER_POOL_ENVIRONMENT_LIST_H_
#define SERVER_POOL_ENVIRONMENT_LIST_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// A list of environment indices in a request, with the names to use in errors.
struct EnvironmentList {
  absl::string_view list = "";    // the list's field, e.g. "pairs"
  absl::string_view member = "";  // an entry's index field, e.g. ".target_environment"
  absl::Span<const int32_t> environments = {};
  bool repeats_allowed = false;  // an environment may be named more than once
};

// Checks that the list has an entry and that all indices are in [0, env_count) of the pool named
// `pool`.
// Errors: INVALID_ARGUMENT; the message gives the entry, its value and the allowed values.
absl::Status CheckEnvironmentList(const EnvironmentList& list, absl::string_view pool,
                                  int32_t env_count);

}  // namespace procgen

#endif  // SERVER_POOL_ENVIRONMENT_LIST_H_
