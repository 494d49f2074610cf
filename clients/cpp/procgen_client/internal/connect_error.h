#ifndef PROCGEN_CLIENT_INTERNAL_CONNECT_ERROR_H_
#define PROCGEN_CLIENT_INTERNAL_CONNECT_ERROR_H_

#include <string>

#include "absl/strings/string_view.h"

namespace procgen_client {

// Returns why waiting cannot make this connection succeed and what to do, if `reason`, gRPC's error
// of an attempt, is caused by wrong credentials. Else empty: the server may still be starting.
// Blocks for at most kProbeTimeout: without TLS, it checks whether the server has TLS.
std::string ExplainConnectError(const std::string& address, absl::string_view reason,
                                bool uses_tls);

// Returns what may cause an error that ExplainConnectError cannot explain; empty: unknown.
absl::string_view LikelyCause(absl::string_view reason, bool uses_tls);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_CONNECT_ERROR_H_
