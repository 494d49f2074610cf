#include "tests/benchmark/bare_stream.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server.h"
#include "grpcpp/server_builder.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/channel_arguments.h"

namespace procgen {
namespace {

constexpr char kMethod[] = "/procgen.benchmark.Bare/Stream";

grpc::ByteBuffer MessageOf(size_t bytes) {
  const grpc::Slice slice(std::string(bytes, 'x'));
  return {&slice, 1};
}

// Answers every message with the same one.
class AnsweringReactor final : public grpc::ServerGenericBidiReactor {
 public:
  explicit AnsweringReactor(const grpc::ByteBuffer& response) : response_(response) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (ok) {
      StartWrite(&response_);
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
  const grpc::ByteBuffer& response_;
  grpc::ByteBuffer request_;
};

class AnsweringService final : public grpc::CallbackGenericService {
 public:
  explicit AnsweringService(size_t response_bytes) : response_(MessageOf(response_bytes)) {}

  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* /*context*/) override {
    // gRPC owns it until OnDone.
    return new AnsweringReactor(response_);
  }

 private:
  const grpc::ByteBuffer response_;
};

class LoopbackStream final : public BareStream {
 public:
  explicit LoopbackStream(const StreamShape& shape)
      : shape_(shape), request_(MessageOf(shape.request_bytes)), service_(shape.response_bytes) {}

  ~LoopbackStream() override {
    context_.TryCancel();
    if (call_ != nullptr) {
      grpc::Status status;
      call_->Finish(&status, this);
      Wait();
    }
    queue_.Shutdown();
    if (server_ != nullptr) {
      server_->Shutdown();
    }
  }

  absl::Status Connect() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterCallbackGenericService(&service_);
    server_ = builder.BuildAndStart();
    if (server_ == nullptr || port == 0) {
      return absl::UnavailableError("the bare stream's server cannot listen on 127.0.0.1");
    }
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);
    stub_ = std::make_unique<grpc::GenericStub>(grpc::CreateCustomChannel(
        absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials(), arguments));
    call_ = stub_->PrepareCall(&context_, kMethod, &queue_);
    call_->StartCall(this);
    return Wait() ? absl::OkStatus() : absl::UnavailableError("the bare stream cannot connect");
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
  // Waits for the one operation that was started.
  bool Wait() {
    void* tag = nullptr;
    bool ok = false;
    return queue_.Next(&tag, &ok) && ok;
  }
  absl::Status Write() {
    call_->Write(request_, this);
    return Wait() ? absl::OkStatus() : Broken();
  }
  absl::Status Read() {
    grpc::ByteBuffer response;
    call_->Read(&response, this);
    return Wait() && response.Length() == shape_.response_bytes ? absl::OkStatus() : Broken();
  }
  static absl::Status Broken() { return absl::UnavailableError("the bare stream broke"); }

  const StreamShape shape_;
  const grpc::ByteBuffer request_;
  AnsweringService service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<grpc::GenericStub> stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
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
