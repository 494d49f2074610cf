#include "server/rpc/response_queue.h"

#include "absl/strings/str_cat.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "server/rpc/shared_bytes.h"

namespace procgen {
namespace {

// One is stepped while the other is on its way.
constexpr int kMessageCount = 2;

}  // namespace

grpc::ByteBuffer Serialized(const v1::StepPoolResponse& response) {
  grpc::ByteBuffer bytes;
  bool own_buffer = false;
  grpc::SerializationTraits<v1::StepPoolResponse>::Serialize(response, &bytes, &own_buffer);
  return bytes;
}

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
  for (int i = 0; i < kMessageCount; ++i) {
    messages_.push_back(std::make_unique<v1::StepPoolResponse>());
    free_.push_back(messages_.back().get());
  }
}

v1::StepPoolResponse* ResponseQueue::Take() {
  if (free_.empty()) {
    messages_.push_back(std::make_unique<v1::StepPoolResponse>());
    return messages_.back().get();
  }
  v1::StepPoolResponse* message = free_.back();
  free_.pop_back();
  return message;
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
  if (written.message != nullptr) {
    GiveBack(written.message);
  }
  return written.answered;
}

void ResponseQueue::DropUnwritten() {
  const size_t kept = writing_ ? 1 : 0;
  while (queue_.size() > kept) {
    if (queue_.back().message != nullptr) {
      GiveBack(queue_.back().message);
    }
    queue_.pop_back();
  }
}

}  // namespace procgen
