#ifndef PROCGEN_CLIENT_INTERNAL_CALL_OPTIONS_H_
#define PROCGEN_CLIENT_INTERNAL_CALL_OPTIONS_H_

#include <memory>
#include <string>

#include "absl/time/time.h"
#include "procgen_client/open_calls.h"

namespace procgen_client {

// Options of each call.
struct CallOptions {
  std::string token;  // empty: no token
  absl::Duration timeout = absl::InfiniteDuration();
  std::shared_ptr<OpenCalls> calls = nullptr;  // never null
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_CALL_OPTIONS_H_
