#include "server/rpc/step/response_queue.h"

#include "absl/strings/str_cat.h"
#include "server/rpc/grpc/shared_bytes.h"

namespace procgen {
namespace {

// One is filled while the other is sent.
constexpr int kResponseCount = 2;

}  // namespace

absl::Status CheckKeptAnswer(int64_t sequence_number, const Answer& answer,
                             int64_t response_bytes_max) {
  for (const absl::Cord& response : answer) {
    if (response.size() > static_cast<size_t>(response_bytes_max)) {
      return absl::ResourceExhaustedError(absl::StrCat(
          "the kept answer to request ", sequence_number, " has a response of ", response.size(),
          " bytes, limit attach.response_bytes_max is ", response_bytes_max));
    }
  }
  return absl::OkStatus();
}

ResponseQueue::ResponseQueue() {
  for (int i = 0; i < kResponseCount; ++i) {
    responses_.push_back(std::make_unique<Response>());
    free_.push_back(responses_.back().get());
  }
}

Response* ResponseQueue::Take() {
  if (free_.empty()) {
    responses_.push_back(std::make_unique<Response>());
    return responses_.back().get();
  }
  Response* response = free_.back();
  free_.pop_back();
  return response;
}

void ResponseQueue::Release(Response* response) {
  response->observations = grpc::Slice();
  free_.push_back(response);
}

void ResponseQueue::PushAnswer(const Answer& answer, StreamRequest* request) {
  for (const absl::Cord& response : answer) {
    const bool is_last = &response == &answer.back();
    Push({nullptr, ByteBufferOf(response), is_last ? request : nullptr});
  }
}

StreamRequest* ResponseQueue::EndWrite() {
  const Outgoing written = std::move(queue_.front());
  queue_.pop_front();
  writing_ = false;
  if (written.response != nullptr) {
    Release(written.response);
  }
  return written.answered;
}

void ResponseQueue::DropUnwritten() {
  const size_t kept = writing_ ? 1 : 0;
  while (queue_.size() > kept) {
    if (queue_.back().response != nullptr) {
      Release(queue_.back().response);
    }
    queue_.pop_back();
  }
}

}  // namespace procgen
