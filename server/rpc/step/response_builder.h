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

// Builds the responses to the requests of a stream, one after the other: provides the memory that a
// part is drawn into and later sent from, and encodes observations if the pool has them encoded.
// Delta state is per stream: the first observation of each environment is a key frame.
// Threads: compatible; used in the turns of one stream.
class ResponseBuilder {
 public:
  // Makes `response` the answer for `part` of `request`. Returns where its values are to be
  // written. `response` must stay valid until Complete.
  Batch Prepare(const PoolSession& pool, const Request& request, Part part, Response* response);
  // The values are written: completes the response. Returns it as it is sent, if `keep`; where it
  // has observations, `bytes` is then the same.
  absl::Cord Complete(const PoolSession& pool, const Request& request, bool keep,
                      Response* response, grpc::ByteBuffer* bytes);
  // Makes the next observation of each environment a key frame.
  void ResetEncoder() { encoder_ = nullptr; }

 private:
  // Replaces the drawn observations by the encoded ones.
  void Encode(const PoolSession& pool, Response* response);

  FrameBufferPool frames_;
  Batch batch_;  // where the values of the response under way are written
  // Made for the first observations; null before, and where they are not encoded.
  std::unique_ptr<ObservationEncoder> encoder_;
};

}  // namespace procgen

#endif  // SERVER_RPC_STEP_RESPONSE_BUILDER_H_
