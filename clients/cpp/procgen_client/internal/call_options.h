#ifndef PROCGEN_CLIENT_INTERNAL_CALL_OPTIONS_H_
#define PROCGEN_CLIENT_INTERNAL_CALL_OPTIONS_H_

#include <string>

#include "absl/time/time.h"
#include "procgen_client/cancellation.h"

namespace procgen_client {

// Options of each call.
struct CallOptions {
  std::string token;  // empty: no token
  absl::Duration timeout = absl::InfiniteDuration();
  CancellationCheck is_cancelled = nullptr;  // null: never
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_CALL_OPTIONS_H_
