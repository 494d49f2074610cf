#include "procgen_client/step_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "procgen_client/credentials.h"
#include "procgen_client/grpc_error.h"

namespace procgen_client {

StepStream::~StepStream() { Close().IgnoreError(); }

absl::Status StepStream::Attach(procgen::v1::StepService::Stub* stub, const std::string& token,
                                const std::string& pool, const StreamOptions& options) {
  ShowToken(token, &context_);
  stream_ = stub->StepPool(&context_);
  procgen::v1::StepPoolRequest request;
  request.mutable_attach()->set_pool(pool);
  request.mutable_attach()->set_requests_in_flight_max(options.requests_in_flight_max);
  request.mutable_attach()->set_response_bytes_max(options.response_bytes_max);
  if (!stream_->Write(request)) {
    return Finish();
  }
  procgen::v1::StepPoolResponse response;
  if (absl::Status status = Read(&response); !status.ok()) {
    return status;
  }
  if (!response.has_attached()) {
    return absl::InternalError("the server's first response does not answer attach");
  }
  attached_.Swap(response.mutable_attached());
  next_sequence_number_ = attached_.next_sequence_number();
  answered_sequence_number_ = next_sequence_number_ - 1;
  return absl::OkStatus();
}

absl::Status StepStream::Step(absl::Span<const int32_t> actions, Batch* batch) {
  procgen::v1::StepPoolRequest request;
  request.mutable_step()->mutable_actions()->Add(actions.begin(), actions.end());
  return Call(std::move(request), batch);
}

absl::Status StepStream::Observe(Batch* batch) {
  procgen::v1::StepPoolRequest request;
  request.mutable_observe();
  return Call(std::move(request), batch);
}

absl::Status StepStream::Call(procgen::v1::StepPoolRequest request, Batch* batch) {
  if (absl::Status status = Over(); !status.ok()) {
    return status;
  }
  if (next_sequence_number_ - 1 != answered_sequence_number_) {
    return absl::FailedPreconditionError("requests are unanswered; receive their answers first");
  }
  absl::StatusOr<int64_t> sent = Send(std::move(request));
  return sent.ok() ? Receive(batch) : sent.status();
}

absl::StatusOr<int64_t> StepStream::Send(procgen::v1::StepPoolRequest request) {
  const int64_t unanswered = next_sequence_number_ - 1 - answered_sequence_number_;
  if (unanswered >= requests_in_flight_max()) {
    return absl::FailedPreconditionError(
        absl::StrCat(unanswered, " requests are unanswered, allowed: ", requests_in_flight_max()));
  }
  if (absl::Status status = Over(); !status.ok()) {
    return status;
  }
  // Counted before it is sent: its answer may arrive before Write returns.
  const int64_t number = next_sequence_number_++;
  request.set_sequence_number(number);
  if (!stream_->Write(request)) {
    return Finish();
  }
  return number;
}

absl::Status StepStream::Receive(Batch* batch) {
  if (absl::Status status = Over(); !status.ok()) {
    return status;
  }
  if (next_sequence_number_ - 1 == answered_sequence_number_) {
    return absl::FailedPreconditionError("no request is unanswered; send one first");
  }
  if (absl::Status status = Read(&batch->response_); !status.ok()) {
    return status;
  }
  batch->Begin();
  bool last = batch->response_.batch().last();
  while (!last) {
    if (absl::Status status = Read(&part_); !status.ok()) {
      return status;
    }
    batch->Append(part_.batch());
    last = part_.batch().last();
  }
  answered_sequence_number_ = batch->sequence_number();
  return absl::OkStatus();
}

absl::Status StepStream::Read(procgen::v1::StepPoolResponse* response) {
  if (!stream_->Read(response)) {
    return Finish();
  }
  return absl::OkStatus();
}

absl::Status StepStream::Over() {
  absl::MutexLock lock(&mutex_);
  return finished_ ? status_ : absl::OkStatus();
}

absl::Status StepStream::Finish() {
  absl::MutexLock lock(&mutex_);
  if (!finished_) {
    finished_ = true;
    status_ = ToAbslStatus(stream_->Finish());
    if (status_.ok()) {
      status_ = absl::FailedPreconditionError("the stream is closed");
    }
  }
  return status_;
}

absl::Status StepStream::Close() {
  {
    absl::MutexLock lock(&mutex_);
    if (finished_) {
      return status_;
    }
    finished_ = true;
    status_ = absl::FailedPreconditionError("the stream is closed");
  }
  stream_->WritesDone();
  while (stream_->Read(&part_)) {
  }
  return ToAbslStatus(stream_->Finish());
}

}  // namespace procgen_client
