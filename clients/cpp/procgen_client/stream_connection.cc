#include "procgen_client/stream_connection.h"

#include "absl/strings/str_cat.h"
#include "procgen_client/call_end.h"

namespace procgen_client {
namespace {

// Maximum number of responses of unknown kinds that are skipped before an answer.
constexpr int kNoticesMax = 1000;

}  // namespace

bool StreamConnection::Write(const procgen::v1::StepPoolRequest& request) const {
  return pipes == nullptr ? stream->Write(request) : pipes->Send(request);
}

bool StreamConnection::Read(procgen::v1::StepPoolResponse* response) const {
  return pipes == nullptr ? stream->Read(response) : pipes->Receive(response);
}

absl::StatusOr<bool> StreamConnection::ReadAnswer(int64_t number,
                                                  procgen::v1::StepPoolResponse* response) const {
  for (int notices = 0; notices <= kNoticesMax; ++notices) {
    if (!Read(response)) {
      if (pipes != nullptr && pipes->is_damaged()) {
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

std::shared_ptr<grpc::ClientContext> ContextOf(
    const std::shared_ptr<StreamConnection>& connection) {
  return {connection, &connection->context};
}

absl::Status AwaitEnd(const std::shared_ptr<StreamConnection>& connection, grpc::Status* end) {
  return AwaitEnd<procgen::v1::StepPoolResponse>(ContextOf(connection), connection->stream.get(),
                                                 end);
}

}  // namespace procgen_client
