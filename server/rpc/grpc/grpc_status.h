#ifndef SERVER_RPC_GRPC_GRPC_STATUS_H_
#define SERVER_RPC_GRPC_GRPC_STATUS_H_

#include <cstddef>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace procgen {

// The most bytes of a message: three times as many, as gRPC writes what is not ASCII, and the rest
// of the trailers fit the 8 KiB that clients take.
inline constexpr size_t kStatusMessageBytesMax = 2048;

// The same code and message, as far as that has room; the numbers of both are the canonical ones.
grpc::Status ToGrpcStatus(const absl::Status& status);

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_GRPC_STATUS_H_
