#include "procgen_client/run/grpc_run_stream.h"

#include <utility>

#include "grpc/support/time.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/grpc_error.h"

namespace procgen_client {
namespace {

// Whether another call may succeed.
bool IsLost(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::CANCELLED:  // a server that stops; this client's own is checked before
    case grpc::StatusCode::INTERNAL:   // HTTP/2 errors
    case grpc::StatusCode::UNKNOWN:    // "Stream removed": gRPC's status after a socket reset
    case grpc::StatusCode::OK:         // the server took the end of the connection for a half-close
      return true;
    default:
      return false;
  }
}

}  // namespace

EventQueue::~EventQueue() {
  queue_.Shutdown();
  void* tag = nullptr;
  bool is_ok = false;
  while (queue_.Next(&tag, &is_ok)) {
  }
}

GrpcRunStream::GrpcRunStream(const std::shared_ptr<grpc::Channel>& channel,
                             const std::string& token, std::shared_ptr<EventQueue> events)
    : events_(std::move(events)), stub_(channel) {
  for (int operation = 0; operation < kOperationCount; ++operation) {
    tags_[static_cast<size_t>(operation)] = {this, static_cast<Operation>(operation)};
  }
  ShowToken(token, &context_);
  call_ = stub_.PrepareCall(&context_, "/procgen.v1.PoolService/RunPool", &events_->queue_);
  Begin(Operation::kStart);
}

GrpcRunStream::~GrpcRunStream() {
  context_.TryCancel();
  // Buffers of operations in progress belong to this object.
  while (operation_count_ > static_cast<int>(done_.size())) {
    Poll(gpr_inf_future(GPR_CLOCK_MONOTONIC));
  }
}

bool GrpcRunStream::Poll(gpr_timespec deadline) {
  void* tag = nullptr;
  bool is_ok = false;
  if (events_->queue_.AsyncNext(&tag, &is_ok, deadline) != grpc::CompletionQueue::GOT_EVENT) {
    return false;
  }
  const Tag& done = *static_cast<Tag*>(tag);
  done.stream->done_.push_back({done.operation, is_ok});
  return true;
}

void GrpcRunStream::Begin(Operation operation) {
  ++operation_count_;
  switch (operation) {
    case Operation::kStart:
      call_->StartCall(TagOf(operation));
      break;
    case Operation::kWrite:
      call_->Write(*waiting_, TagOf(operation));
      break;
    case Operation::kHalfClose:
      call_->WritesDone(TagOf(operation));
      break;
    case Operation::kRead:
      call_->Read(&read_, TagOf(operation));
      break;
    case Operation::kFinish:
      call_->Finish(&grpc_status_, TagOf(operation));
      break;
  }
}

void GrpcRunStream::Write(const procgen::v1::RunPoolRequest& request) {
  const grpc::Slice slice(request.SerializeAsString());
  waiting_ = grpc::ByteBuffer(&slice, 1);
  if (is_established_ && !is_failed_) {
    Begin(Operation::kWrite);
  }
}

void GrpcRunStream::HalfClose() {
  if (is_established_ && !is_failed_) {
    Begin(Operation::kHalfClose);
  }
}

RunStream::Event GrpcRunStream::Next(absl::Duration timeout) {
  if (is_over_) {
    return Event::kEnd;
  }
  const gpr_timespec deadline =
      gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                   gpr_time_from_nanos(absl::ToInt64Nanoseconds(timeout), GPR_TIMESPAN));
  while (true) {
    while (done_.empty()) {
      if (!Poll(deadline)) {
        return Event::kNone;
      }
    }
    const Done done = done_.front();
    done_.pop_front();
    --operation_count_;
    const Event event = On(done.operation, done.is_ok);
    if (event != Event::kNone) {
      return event;
    }
  }
}

RunStream::Event GrpcRunStream::On(Operation operation, bool is_ok) {
  if (operation == Operation::kFinish) {
    is_over_ = true;
    is_lost_ = IsLost(grpc_status_);
    status_ = grpc_status_.ok() ? absl::UnavailableError("the server ended the stream")
                                : ToAbslStatus(grpc_status_);
    return Event::kEnd;
  }
  if (operation == Operation::kRead && is_ok) {
    response_.Swap(&read_);
    read_.Clear();
    Begin(Operation::kRead);
    return Event::kResponse;
  }
  if (operation == Operation::kStart && is_ok) {
    is_established_ = true;
    Begin(Operation::kRead);
    if (waiting_.has_value()) {
      Begin(Operation::kWrite);
    }
    return Event::kNone;
  }
  if (operation == Operation::kWrite && is_ok) {
    waiting_ = std::nullopt;
    return Event::kWritten;
  }
  // After a failed write, responses that have arrived are still to be read.
  const bool is_of_requests = operation == Operation::kWrite || operation == Operation::kHalfClose;
  if (!is_of_requests && !is_failed_) {
    is_failed_ = true;
    Begin(Operation::kFinish);
  }
  return Event::kNone;
}

}  // namespace procgen_client
