#include "server/rpc/step/response_builder.h"

#include "server/rpc/grpc/shared_bytes.h"
#include "server/wire/convert_shared.h"
#include "server/wire/convert_step.h"

namespace procgen {

Batch ResponseBuilder::Prepare(const PoolSession& pool, const Request& request, Part part,
                               Response* response) {
  batch_ = request.shared_batch >= 0
               ? PrepareSharedResponse(request, *pool.shared_batch_slots(), &response->message)
               : PrepareResponse(request, part, pool.observation_bytes(), &frames_, response);
  return batch_;
}

absl::Cord ResponseBuilder::Complete(const PoolSession& pool, const Request& request, bool keep,
                                     Response* response, grpc::ByteBuffer* bytes) {
  CompleteResponse(pool.observation_bytes(), batch_, &response->message);
  if (pool.coding().encoding() != Encoding::kRaw && request.with_observations) {
    Encode(pool, response);
  }
  if (!keep) {
    return {};
  }
  if (response->observations.size() == 0) {
    // Serialising such a small message twice is cheaper than sharing its bytes.
    return absl::Cord(response->message.SerializeAsString());
  }
  *bytes = Serialized(*response);
  return CordOf(*bytes);
}

void ResponseBuilder::Encode(const PoolSession& pool, Response* response) {
  if (encoder_ == nullptr) {
    encoder_ = pool.coding().MakeEncoder(pool.env_count());
  }
  const v1::Batch& batch = response->message.batch();
  const grpc::Slice& drawn = response->observations;
  const absl::Span<const uint8_t> observations(drawn.begin(), drawn.size());
  response->observations =
      grpc::Slice(encoder_->Encode(batch.first_env(), batch.env_count(), observations));
}

}  // namespace procgen
