#include "tests/benchmark/learners/bare_stream.h"

#include <array>
#include <string>

#include "absl/strings/str_cat.h"
#include "grpcpp/client_context.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "grpcpp/support/channel_arguments.h"
#include "grpcpp/support/server_callback.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/pool_service.grpc.pb.h"

namespace procgen {
namespace {

// One being written, one in transit and one just sent.
constexpr size_t kPlaceCount = 3;

// Responses with `response_bytes` of observations; empty messages for 0.
v1::RunPoolRequest RequestOf(size_t bytes) {
  v1::RunPoolRequest request;
  if (bytes > 0) {
    request.mutable_step()->mutable_actions()->Resize(static_cast<int>(bytes), 0);
  }
  return request;
}
v1::RunPoolResponse ResponseOf(size_t bytes) {
  v1::RunPoolResponse response;
  if (bytes > 0) {
    response.mutable_batch()->mutable_observations()->assign(bytes, 'x');
  }
  return response;
}

using Responses = std::array<v1::RunPoolResponse, kPlaceCount>;

// Answers every message with the next response.
class AnsweringReactor final
    : public grpc::ServerBidiReactor<v1::RunPoolRequest, v1::RunPoolResponse> {
 public:
  explicit AnsweringReactor(const Responses& responses) : responses_(responses) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (ok) {
      StartWrite(&responses_[next_++ % kPlaceCount]);
    } else {
      Finish(grpc::Status::OK);
    }
  }
  void OnWriteDone(bool ok) override {
    if (ok) {
      StartRead(&request_);
    } else {
      Finish(grpc::Status::CANCELLED);
    }
  }
  void OnDone() override { delete this; }

 private:
  const Responses& responses_;
  size_t next_ = 0;
  v1::RunPoolRequest request_;
};

class AnsweringService final : public v1::PoolService::CallbackService {
 public:
  explicit AnsweringService(size_t response_bytes) {
    for (v1::RunPoolResponse& response : responses_) {
      response = ResponseOf(response_bytes);
    }
  }

  grpc::ServerBidiReactor<v1::RunPoolRequest, v1::RunPoolResponse>* RunPool(
      grpc::CallbackServerContext* /*context*/) override {
    // Owned by gRPC until OnDone.
    return new AnsweringReactor(responses_);
  }

 private:
  Responses responses_;
};

class LoopbackStream final : public BareStream {
 public:
  explicit LoopbackStream(const StreamShape& shape)
      : shape_(shape), request_(RequestOf(shape.request_bytes)), service_(shape.response_bytes) {}

  ~LoopbackStream() override {
    context_.TryCancel();
    if (stream_ != nullptr) {
      stream_->Finish();
    }
    if (server_ != nullptr) {
      server_->Shutdown();
    }
  }

  absl::Status Connect() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    if (server_ == nullptr || port == 0) {
      return absl::UnavailableError("the bare stream's server cannot listen on 127.0.0.1");
    }
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);
    stub_ = v1::PoolService::NewStub(grpc::CreateCustomChannel(
        absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials(), arguments));
    stream_ = stub_->RunPool(&context_);
    return absl::OkStatus();
  }

  absl::Status SendAhead() override {
    absl::Status status;
    for (int ahead = 1; ahead < shape_.requests_in_flight && status.ok(); ++ahead) {
      status = Write();
    }
    return status;
  }

  absl::Status Exchange() override {
    absl::Status status = Write();
    return status.ok() ? Read() : status;
  }

  absl::Status ReceiveRest() override {
    absl::Status status;
    for (int ahead = 1; ahead < shape_.requests_in_flight && status.ok(); ++ahead) {
      status = Read();
    }
    return status;
  }

 private:
  absl::Status Write() { return stream_->Write(request_) ? absl::OkStatus() : Broken(); }
  absl::Status Read() {
    return stream_->Read(&response_) &&
                   response_.batch().observations().size() == shape_.response_bytes
               ? absl::OkStatus()
               : Broken();
  }
  static absl::Status Broken() { return absl::UnavailableError("the bare stream broke"); }

  const StreamShape shape_;
  const v1::RunPoolRequest request_;
  v1::RunPoolResponse response_;
  AnsweringService service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<v1::PoolService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::RunPoolRequest, v1::RunPoolResponse>> stream_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<BareStream>> BareStream::Start(const StreamShape& shape) {
  auto stream = std::make_unique<LoopbackStream>(shape);
  if (absl::Status status = stream->Connect(); !status.ok()) {
    return status;
  }
  return stream;
}

}  // namespace procgen
