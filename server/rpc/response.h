#ifndef SERVER_RPC_RESPONSE_H_
#define SERVER_RPC_RESPONSE_H_

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"
#include "procgen/v1/step.pb.h"

namespace procgen {

// A response of StepPool: its message, and beside it the field that is nearly all of it.
struct Response {
  v1::StepPoolResponse message;  // all but batch.observations
  grpc::Slice observations;      // these; empty: none. REQUIRES: if not empty, message has a batch
};

// The bytes of a response on the wire, the same as those of a message with everything in it. The
// observations are shared, not copied.
grpc::ByteBuffer Serialized(const Response& response);

}  // namespace procgen

#endif  // SERVER_RPC_RESPONSE_H_
