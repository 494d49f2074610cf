#ifndef PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_
#define PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace procgen_client {

// Converts a status of a server. Control characters of its message, which a terminal would execute
// as escape sequences, become "\x1b" and the like; everything else stays.
absl::Status ToAbslStatus(const grpc::Status& status);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_
