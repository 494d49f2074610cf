#ifndef SERVER_RPC_STEP_RESPONSE_H_
#define SERVER_RPC_STEP_RESPONSE_H_

#include <cstdint>

#include "envcore/pool/pool.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"
#include "procgen/v1/step.pb.h"
#include "server/rpc/step/frame_buffer_pool.h"
#include "server/session/backend/request.h"

namespace procgen {

// A response of StepPool: its message, and beside it the field that is nearly all of it.
struct Response {
  v1::StepPoolResponse message;  // all but batch.observations
  grpc::Slice observations;      // these; empty: none. REQUIRES: if not empty, message has a batch
};

// Makes `response` the answer for `part` of `request`, and returns where its values are to be
// written: observations in memory of `frames`, all else in its message, whose memory is kept from
// answer to answer.
Batch PrepareResponse(const Request& request, Part part, int64_t observation_bytes,
                      FrameBufferPool* frames, Response* response);

// Once the values of `batch` are written: puts the fingerprints and final observations of episodes
// that ended one behind the other, and leaves no others in `response`, if it bears them itself.
void CompleteResponse(int64_t observation_bytes, const Batch& batch,
                      v1::StepPoolResponse* response);

// The bytes of a response on the wire, the same as those of a message with everything in it. The
// observations are shared, not copied.
grpc::ByteBuffer Serialized(const Response& response);

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESPONSE_H_
