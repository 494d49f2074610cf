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

// A response of StepPool. The observations, nearly all of its bytes, are separate from the message.
struct Response {
  v1::StepPoolResponse message;  // without batch.observations
  grpc::Slice observations;      // batch.observations; if not empty, message has a batch
};

// Makes `response` the response to `part` of `request` and returns the arrays for its values:
// observations in memory of `frames`, all others in the message, whose memory is reused.
Batch PrepareResponse(const Request& request, Part part, int64_t observation_bytes,
                      FrameBufferPool* frames, Response* response);

// Completes `response` after the values of `batch` are written: compacts the fingerprints and final
// observations to those of ended episodes, and truncates the fields of `response` if it contains
// them (not with shared memory).
void CompleteResponse(int64_t observation_bytes, const Batch& batch,
                      v1::StepPoolResponse* response);

// Serialises a response to the bytes of a message that contains the observations. The observations
// are shared, not copied.
grpc::ByteBuffer Serialized(const Response& response);

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESPONSE_H_
