#ifndef SERVER_RPC_GRPC_GRPC_STATUS_H_
#define SERVER_RPC_GRPC_GRPC_STATUS_H_

#include <cstddef>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace procgen {

// Largest size of a status message, in bytes. gRPC percent-encodes non-ASCII bytes, which triples
// their size; with the other trailers this fits in the 8 KiB that clients accept.
inline constexpr size_t kStatusMessageBytesMax = 2048;

// Converts a status: the same canonical code, and the message truncated to kStatusMessageBytesMax.
grpc::Status ToGrpcStatus(const absl::Status& status);

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_GRPC_STATUS_H_
