#ifndef SERVER_RPC_GRPC_SHARED_BYTES_H_
#define SERVER_RPC_GRPC_SHARED_BYTES_H_

#include "absl/strings/cord.h"
#include "grpcpp/support/byte_buffer.h"

namespace procgen {

// The same bytes, held by gRPC and by those who know nothing of it. Nothing is copied (but pieces
// of a few bytes): both share the memory, and the last to let go frees it.
absl::Cord CordOf(const grpc::ByteBuffer& bytes);
grpc::ByteBuffer ByteBufferOf(const absl::Cord& bytes);

}  // namespace procgen

#endif  // SERVER_RPC_GRPC_SHARED_BYTES_H_
