#include "procgen_client/stream_connection.h"

#include "absl/strings/str_cat.h"
#include "grpc/support/time.h"

namespace procgen_client {
namespace {

// How long a server may take to end a stream that is over.
constexpr absl::Duration kEndTimeout = absl::Seconds(10);
// So many responses of kinds that are not known are ignored before an answer.
constexpr int kNoticesMax = 1000;

}  // namespace

bool StreamConnection::Write(const procgen::v1::StepPoolRequest& request) const {
  return line == nullptr ? stream->Write(request) : line->Send(request);
}

bool StreamConnection::Read(procgen::v1::StepPoolResponse* response) const {
  return line == nullptr ? stream->Read(response) : line->Receive(response);
}

absl::StatusOr<bool> StreamConnection::ReadAnswer(int64_t number,
                                                  procgen::v1::StepPoolResponse* response) const {
  for (int notices = 0; notices <= kNoticesMax; ++notices) {
    if (!Read(response)) {
      if (line != nullptr && line->is_damaged()) {
        return absl::DataLossError(absl::StrCat("the server's answer to request ", number,
                                                ": what came by the pipe is no response"));
      }
      return false;
    }
    // One of a later server's kinds that answers nothing is not for this client.
    if (response->response_case() != procgen::v1::StepPoolResponse::RESPONSE_NOT_SET ||
        response->sequence_number() != 0) {
      return true;
    }
  }
  return absl::DataLossError(absl::StrCat("the server's answer to request ", number, ": more than ",
                                          kNoticesMax, " responses of unknown kinds before it"));
}

CallTimer::CallTimer(const std::shared_ptr<StreamConnection>& connection, absl::Duration timeout) {
  if (timeout == absl::InfiniteDuration()) {
    return;
  }
  const gpr_timespec time =
      gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                   gpr_time_from_millis(absl::ToInt64Milliseconds(timeout), GPR_TIMESPAN));
  alarm_.Set(time, [connection, is_due = is_due_](bool rings) {
    if (rings) {
      *is_due = true;
      connection->context.TryCancel();
    }
  });
}

absl::Status AwaitEnd(const std::shared_ptr<StreamConnection>& connection, grpc::Status* end) {
  const CallTimer timer(connection, kEndTimeout);
  // gRPC tells the end to who has read all.
  procgen::v1::StepPoolResponse dropped;
  while (connection->stream->Read(&dropped)) {
  }
  *end = connection->stream->Finish();
  return timer.is_due()
             ? absl::DeadlineExceededError(absl::StrCat("the server did not end the stream within ",
                                                        absl::FormatDuration(kEndTimeout)))
             : absl::OkStatus();
}

}  // namespace procgen_client
