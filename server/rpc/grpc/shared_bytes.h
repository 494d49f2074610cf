#ifndef SERVER_RPC_GRPC_SHARED_BYTES_H_
#define SERVER_RPC_GRPC_SHARED_BYTES_H_

#include "absl/strings/cord.h"
#include "grpcpp/support/byte_buffer.h"

namespace procgen {

// Converts between gRPC buffers and Cords without copying (except pieces of a few bytes). Both
// share the memory, which the last reference frees.
absl::Cord CordOf(const grpc::ByteBuffer& bytes);
grpc::ByteBuffer ByteBufferOf(const absl::Cord& bytes);

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_SHARED_BYTES_H_
