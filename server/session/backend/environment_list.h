#ifndef SERVER_SESSION_BACKEND_ENVIRONMENT_LIST_H_
#define SERVER_SESSION_BACKEND_ENVIRONMENT_LIST_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"

namespace procgen {

// Environments of a pool that a request names one by one, and what the request calls them.
struct EnvironmentList {
  absl::string_view list = "";    // the list's field, e.g. "pairs"
  absl::string_view member = "";  // or what of an entry is the index, e.g. ".target_environment"
  absl::Span<const int32_t> environments = {};
  bool repeats_allowed = false;  // an environment may be named more than once
};

// Checks that there is at least one, and that all are in [0, env_count) of the pool named `pool`.
// Errors: INVALID_ARGUMENT (the message says which entry, what was given and what is allowed).
absl::Status CheckEnvironmentList(const EnvironmentList& list, absl::string_view pool,
                                  int32_t env_count);

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_ENVIRONMENT_LIST_H_
