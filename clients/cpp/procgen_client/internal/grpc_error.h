#ifndef PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_
#define PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_

#include "absl/status/status.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/status.h"

namespace procgen_client {

// Converts a status; code and message stay.
absl::Status ToAbslStatus(const grpc::Status& status);

// Whether a stream that ended with `status` ended because its connection broke, so that a retry may
// succeed. False for an error of the server, and for a server that drains.
bool IsBrokenConnection(const grpc::Status& status, const grpc::ClientContext& context);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_GRPC_ERROR_H_
