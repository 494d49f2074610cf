#ifndef SERVER_RPC_GRPC_STATUS_H_
#define SERVER_RPC_GRPC_STATUS_H_

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace procgen {

// The same code and message; the numbers of both are the canonical ones.
grpc::Status ToGrpcStatus(const absl::Status& status);

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_STATUS_H_
