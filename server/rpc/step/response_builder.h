#ifndef SERVER_RPC_STEP_RESPONSE_BUILDER_H_
#define SERVER_RPC_STEP_RESPONSE_BUILDER_H_

#include <memory>

#include "absl/strings/cord.h"
#include "envcore/pool/pool.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/encoding/observation_encoder.h"
#include "server/rpc/step/frame_buffer_pool.h"
#include "server/rpc/step/response.h"
#include "server/session/pool/pool_session.h"

namespace procgen {

// Builds the responses of a stream, one after the other: provides the memory that a part is drawn
// into and sent from, and encodes the observations if the pool has an encoding. Delta state is per
// stream: the first observation of each environment is a key frame.
// Threads: compatible; used in the turns of one stream.
class ResponseBuilder {
 public:
  // Makes `response` the response to `part` of `request`. Returns the arrays for its values.
  // `response` must stay valid until Complete.
  Batch Prepare(const PoolSession& pool, const Request& request, Part part, Response* response);
  // Completes the response after its values are written. If `keep`, returns its serialised bytes
  // and, if it has observations, sets `bytes` to the same.
  absl::Cord Complete(const PoolSession& pool, const Request& request, bool keep,
                      Response* response, grpc::ByteBuffer* bytes);
  // Makes the next observation of each environment a key frame.
  void ResetEncoder() { encoder_ = nullptr; }

 private:
  // Replaces the drawn observations by the encoded ones.
  void Encode(const PoolSession& pool, Response* response);

  FrameBufferPool frames_;
  Batch batch_;  // the arrays of the current response
  // Created for the first observations; null before and without an encoding.
  std::unique_ptr<ObservationEncoder> encoder_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESPONSE_BUILDER_H_
