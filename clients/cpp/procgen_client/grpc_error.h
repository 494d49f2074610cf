#ifndef PROCGEN_CLIENT_GRPC_ERROR_H_
#define PROCGEN_CLIENT_GRPC_ERROR_H_

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace procgen_client {

// The same code and message.
absl::Status ToAbslStatus(const grpc::Status& status);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_GRPC_ERROR_H_
