#include "server/rpc/services/remote_states.h"

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "procgen/v1/states.grpc.pb.h"
#include "server/logging/event_log.h"
#include "server/rpc/grpc/grpc_deadline.h"

namespace procgen {
namespace {

std::shared_ptr<grpc::Channel> ChannelTo(const Address& address) {
  grpc::ChannelArguments arguments;
  // No proxy: the connection must go to the allowed address.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(GrpcTargetOf(address), grpc::InsecureChannelCredentials(),
                                   arguments);
}

// One fetch. Shared, because the callback of the current call, which owns it, must be copyable.
class RemoteStatesFetch final : public std::enable_shared_from_this<RemoteStatesFetch> {
 public:
  RemoteStatesFetch(const grpc::CallbackServerContext& caller, RemoteEnvironments source,
                    RemoteStatesDone done)
      : caller_(caller),
        source_(std::move(source)),
        done_(std::move(done)),
        deadline_(GrpcDeadlineIn(kRemoteStatesTimeout)),
        stub_(v1::StateService::NewStub(ChannelTo(source_.address))) {
    request_.set_pool(source_.pool);
    request_.mutable_environments()->Add(source_.environments.begin(), source_.environments.end());
  }

  void RequestPage() {
    context_ = grpc::ClientContext::FromCallbackServerContext(caller_);
    context_->set_deadline(deadline_);
    response_.Clear();
    stub_->async()->SaveStates(
        context_.get(), &request_, &response_,
        [self = shared_from_this()](const grpc::Status& status) { self->OnPage(status); });
  }

 private:
  void OnPage(const grpc::Status& answered) {
    absl::Status status = answered.ok() ? TakePage() : ErrorOf(answered);
    if (status.ok() && !response_.next_page_token().empty()) {
      request_.set_page_token(response_.next_page_token());
      RequestPage();
      return;
    }
    if (status.ok() && snapshots_.size() != source_.environments.size()) {
      status = UnexpectedResponse();
    }
    if (status.ok()) {
      done_(std::move(snapshots_));
    } else {
      done_(std::move(status));
    }
  }

  absl::Status TakePage() {
    for (v1::State& state : *response_.mutable_states()) {
      if (snapshots_.size() == source_.environments.size() ||
          state.environment() != source_.environments[snapshots_.size()]) {
        return UnexpectedResponse();
      }
      bytes_ += static_cast<int64_t>(state.snapshot().size());
      if (bytes_ > kRemoteStatesBytesMax) {
        return absl::ResourceExhaustedError(
            absl::StrCat("source_server ", source_.server, " has more than ", kRemoteStatesBytesMax,
                         " bytes of snapshots, which is the limit"));
      }
      snapshots_.push_back(std::move(*state.mutable_snapshot()));
    }
    // Empty pages could continue indefinitely.
    return response_.states().empty() ? UnexpectedResponse() : absl::OkStatus();
  }

  // Whether `code` is an error of SaveStates. gRPC has other codes for connections that fail, time
  // out or reach a different kind of server.
  static bool IsSourceError(absl::StatusCode code) {
    switch (code) {
      case absl::StatusCode::kInvalidArgument:
      case absl::StatusCode::kNotFound:
      case absl::StatusCode::kFailedPrecondition:
      case absl::StatusCode::kResourceExhausted:
      case absl::StatusCode::kAborted:
      case absl::StatusCode::kDataLoss:
        return true;
      default:
        return false;
    }
  }

  absl::Status UnexpectedResponse() const {
    return absl::InternalError(absl::StrCat("source_server ", source_.server,
                                            " returned other environments of pool ", source_.pool,
                                            " than requested"));
  }

  absl::Status ErrorOf(const grpc::Status& answered) const {
    const auto code = static_cast<absl::StatusCode>(answered.error_code());
    absl::Status error(
        code, absl::StrCat("source_server ", source_.server, ": ", answered.error_message()));
    if (IsSourceError(code)) {
      return error;
    }
    // Other errors go only to the log, so that a caller cannot probe ports and paths.
    LogEvent(LogLevel::kInfo, "clone_source_failed",
             {{"source", source_.server}, {"message", error.ToString()}});
    return absl::UnavailableError(
        absl::StrCat("source_server ", source_.server, " cannot be reached within ",
                     absl::FormatDuration(kRemoteStatesTimeout),
                     ", or does not return states to callers without credentials"));
  }

  const grpc::CallbackServerContext& caller_;
  const RemoteEnvironments source_;
  RemoteStatesDone done_;
  const gpr_timespec deadline_;
  const std::unique_ptr<v1::StateService::Stub> stub_;
  v1::SaveStatesRequest request_;
  v1::SaveStatesResponse response_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::vector<std::string> snapshots_;
  int64_t bytes_ = 0;
};

}  // namespace

void FetchRemoteStates(const grpc::CallbackServerContext& caller, RemoteEnvironments source,
                       RemoteStatesDone done) {
  std::make_shared<RemoteStatesFetch>(caller, std::move(source), std::move(done))->RequestPage();
}

}  // namespace procgen
