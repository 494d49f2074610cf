#include "server/rpc/running_request.h"

#include <algorithm>
#include <utility>

#include "server/rpc/convert_shared.h"
#include "server/rpc/shared_bytes.h"

namespace procgen {
namespace {

// REQUIRES: number > 0.
int32_t QuotientUp(int32_t number, int32_t divisor) { return (number - 1) / divisor + 1; }

}  // namespace

void RunningRequest::Begin(StreamRequest* request) {
  request_ = request;
  begin_time_ = SteadyNow();
  queued_ = begin_time_ - request->arrival_time;
  sequence_number_ = request->request.sequence_number;
  rest_ = request->request.count;
  part_ = {request->request.first, 0};
  if (rest_ > 0) {
    parts_left_ = std::max(std::min(request->response_count_min, rest_),
                           QuotientUp(rest_, request->rows_max));
  }
  SelectNextPart();
  answer_.clear();
}

void RunningRequest::RunPart(PoolSession* pool, Response* response, PoolSession::Done done,
                             PoolSession::NearEnd near_end) {
  response_ = response;
  batch_ = {};
  if (response != nullptr && request_->request.shared_batch >= 0) {
    batch_ = PrepareSharedResponse(*request_, *pool->shared_ring(), &response->message);
  } else if (response != nullptr) {
    batch_ = PrepareResponse(*request_, part_, pool->observation_bytes(), &frames_, response);
  }
  pool->RunPart(request_->request, part_, batch_, std::move(done), std::move(near_end));
}

Outgoing RunningRequest::EndPart(const PoolSession& pool, bool ok, bool keeps) {
  Outgoing outgoing = {std::exchange(response_, nullptr), {}, nullptr};
  rest_ = ok ? rest_ - part_.count : 0;
  SelectNextPart();
  if (!ok) {
    answer_.clear();
  } else if (outgoing.response != nullptr) {
    CompleteResponse(pool.observation_bytes(), batch_, &outgoing.response->message);
    if (pool.coding().compression().has_value() && request_->with_observations) {
      Encode(pool, outgoing.response);
    }
    outgoing.answered = IsOver() ? request_ : nullptr;
    if (keeps && outgoing.response->observations.size() == 0) {
      // So few bytes are written sooner than shared, and once more when they are sent.
      answer_.emplace_back(outgoing.response->message.SerializeAsString());
    } else if (keeps) {
      outgoing.bytes = Serialized(*outgoing.response);
      answer_.push_back(CordOf(outgoing.bytes));
    }
  }
  return outgoing;
}

void RunningRequest::Encode(const PoolSession& pool, Response* response) {
  if (encoder_ == nullptr) {
    encoder_ = pool.coding().MakeEncoder(pool.env_count());
  }
  const v1::Batch& batch = response->message.batch();
  const grpc::Slice& drawn = response->observations;
  const absl::Span<const uint8_t> observations(drawn.begin(), drawn.size());
  response->observations = grpc::Slice(
      encoder_->Encode(batch.first_environment(), batch.environment_count(), observations));
}

void RunningRequest::SelectNextPart() {
  part_.first += part_.count;
  part_.count = rest_ == 0 ? 0 : QuotientUp(rest_, parts_left_);
  --parts_left_;
}

Answer RunningRequest::TakeAnswer() { return std::exchange(answer_, {}); }

}  // namespace procgen
