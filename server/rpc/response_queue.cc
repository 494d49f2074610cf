#include "server/rpc/response_queue.h"

#include "grpcpp/impl/codegen/proto_utils.h"

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
