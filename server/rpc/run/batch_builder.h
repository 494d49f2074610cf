#ifndef SERVER_RPC_RUN_BATCH_BUILDER_H_
#define SERVER_RPC_RUN_BATCH_BUILDER_H_

#include <cstdint>
#include <memory>

#include "envcore/pool/pool.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen/v1/run.pb.h"
#include "server/encoding/observation_encoder.h"
#include "server/pool/pool_session.h"
#include "server/pool/request.h"
#include "server/rpc/run/frame_buffer_pool.h"

namespace procgen {

// Builds the batches of a RunPool stream: provides the memory that a batch is drawn into and sent
// from, and encodes observations.
// Threads: compatible.
class BatchBuilder {
 public:
  explicit BatchBuilder(const PoolSession& pool);

  // Returns the arrays for the response to `request`, whose slice is complete. Valid until Finish.
  Batch Prepare(const Request& request);
  // Returns the serialised response after its arrays were written.
  grpc::ByteBuffer Finish();

 private:
  const int64_t observation_bytes_;
  FrameBufferPool frames_;
  const std::unique_ptr<ObservationEncoder> encoder_;  // null: observations are sent as drawn
  v1::RunPoolResponse response_;                       // without batch.observations
  Batch batch_;                                        // the arrays of response_ and observations_
  grpc::Slice observations_;                           // batch.observations
};

// Serialises a response other than a batch.
grpc::ByteBuffer Serialized(const v1::RunPoolResponse& response);

}  // namespace procgen

#endif  // SERVER_RPC_RUN_BATCH_BUILDER_H_
