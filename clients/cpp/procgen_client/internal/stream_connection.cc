#include "procgen_client/internal/stream_connection.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "procgen_client/credentials.h"
#include "procgen_client/internal/call_end.h"
#include "procgen_client/internal/timing.h"

namespace procgen_client {
namespace {

// Maximum number of responses of unknown kinds that are skipped before an answer.
constexpr int kNoticesMax = 1000;

}  // namespace

StreamConnection::StreamConnection(std::shared_ptr<Cancellation> cancellation,
                                   const std::string& token, bool waits_for_server)
    : cancellation_(std::move(cancellation)), completions_(&context_, cancellation_.get()) {
  context_.set_wait_for_ready(waits_for_server);
  ShowToken(token, &context_);
}

// What is under way uses the stream, so it ends first.
StreamConnection::~StreamConnection() { completions_.Drain(); }

bool StreamConnection::Start(procgen::v1::StepService::Stub* stub,
                             const procgen::v1::StepPoolRequest& attach) {
  stream_ = stub->AsyncStepPool(&context_, completions_.queue(),
                                CallCompletions::TagOf(CallOperation::kStart));
  return completions_.Await(CallOperation::kStart) && Write(attach);
}

void StreamConnection::OpenPipes(const procgen::v1::Attached& attached) {
  pipes_ = PipeTransport::Open(attached.shared_memory().pipe_transport(),
                               attached.response_bytes_max(), cancellation_);
}

void StreamConnection::Interrupt() {
  context_.TryCancel();
  if (pipes_ != nullptr) {
    pipes_->Interrupt();
  }
}

bool StreamConnection::Write(const procgen::v1::StepPoolRequest& request) {
  if (pipes_ != nullptr) {
    return pipes_->Send(request);
  }
  stream_->Write(request, CallCompletions::TagOf(CallOperation::kWrite));
  return completions_.Await(CallOperation::kWrite);
}

bool StreamConnection::Read(procgen::v1::StepPoolResponse* response) {
  if (pipes_ == nullptr) {
    return ReadFromCall(response);
  }
  const bool is_there = pipes_->Receive(response);
  if (!is_there && cancellation_->Check()) {
    context_.TryCancel();
  }
  return is_there;
}

bool StreamConnection::ReadFromCall(procgen::v1::StepPoolResponse* response) {
  stream_->Read(response, CallCompletions::TagOf(CallOperation::kRead));
  return completions_.Await(CallOperation::kRead);
}

absl::StatusOr<bool> StreamConnection::ReadAnswer(int64_t number,
                                                  procgen::v1::StepPoolResponse* response) {
  for (int notices = 0; notices <= kNoticesMax; ++notices) {
    if (!Read(response)) {
      if (pipes_ != nullptr && pipes_->is_damaged()) {
        return absl::DataLossError(absl::StrCat("the server's answer to request ", number,
                                                ": a malformed response on the pipe"));
      }
      return false;
    }
    // Skips responses of kinds that only newer clients know.
    if (response->response_case() != procgen::v1::StepPoolResponse::RESPONSE_NOT_SET ||
        response->sequence_number() != 0) {
      return true;
    }
  }
  return absl::DataLossError(absl::StrCat("the server's answer to request ", number, ": more than ",
                                          kNoticesMax, " responses of unknown kinds before it"));
}

void StreamConnection::EndRequests() {
  if (pipes_ != nullptr) {
    pipes_->HangUp();
  }
  stream_->WritesDone(CallCompletions::TagOf(CallOperation::kWritesDone));
  completions_.Await(CallOperation::kWritesDone);
}

absl::Status StreamConnection::AwaitEnd(grpc::Status* end) {
  const CallTimer timer(context(), kEndTimeout);
  ReadEnd(end);
  return timer.is_due()
             ? absl::DeadlineExceededError(absl::StrCat("the server did not end the stream within ",
                                                        absl::FormatDuration(kEndTimeout)))
             : absl::OkStatus();
}

absl::Status StreamConnection::AwaitEndAfterFailure(grpc::Status* end) {
  const CallTimer timer(context(), kEndReportTimeout);
  ReadEnd(end);
  return CheckLastResponse(timer);
}

void StreamConnection::ReadEnd(grpc::Status* end) {
  if (end_.has_value()) {
    *end = *end_;
    return;
  }
  // gRPC returns the status only after all responses have been read.
  procgen::v1::StepPoolResponse dropped;
  while (ReadFromCall(&dropped)) {
  }
  stream_->Finish(end, CallCompletions::TagOf(CallOperation::kFinish));
  completions_.Await(CallOperation::kFinish);
  end_ = *end;
}

}  // namespace procgen_client
