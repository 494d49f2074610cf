#include "tests/benchmark/bare_stream.h"

#include <string>

#include "absl/status/status.h"
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
#include "tests/benchmark/time_now.h"

namespace procgen {
namespace {

constexpr absl::Duration kMeasuringTime = absl::Milliseconds(100);
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

  absl::Duration MeasureExchange() override {
    const absl::Duration start = TimeNow(TimeKind::kWall);
    absl::Duration elapsed;
    int exchanges = 0;
    // The first requests are sent ahead; each response lets the next one go.
    bool ok = true;
    for (int ahead = 1; ahead < shape_.requests_in_flight; ++ahead) {
      ok = ok && Write();
    }
    while (ok && elapsed < kMeasuringTime) {
      ok = Write() && Read();
      ++exchanges;
      elapsed = TimeNow(TimeKind::kWall) - start;
    }
    for (int ahead = 1; ahead < shape_.requests_in_flight; ++ahead) {
      ok = ok && Read();
    }
    return ok ? elapsed / exchanges : absl::InfiniteDuration();
  }

 private:
  // Waits for the one operation that was started.
  bool Wait() {
    void* tag = nullptr;
    bool ok = false;
    return queue_.Next(&tag, &ok) && ok;
  }
  bool Write() {
    call_->Write(request_, this);
    return Wait();
  }
  bool Read() {
    grpc::ByteBuffer response;
    call_->Read(&response, this);
    return Wait() && response.Length() == shape_.response_bytes;
  }

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
