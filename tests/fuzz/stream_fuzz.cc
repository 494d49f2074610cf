// Fuzz target: the messages of a stream of StepPool. An input is pieces (fuzzed_server.h): each is
// a message that is sent, or a mark, which cancels the stream; at the end it is half-closed and all
// answers are read. Aborts where
//   an error is one that is not promised;
//   a response is no message, or answers before `attached`, or answers go back in number;
//   a stream that has ended keeps its pool, or the pool takes no other stream.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "grpcpp/generic/generic_stub.h"
#include "procgen/v1/step.pb.h"
#include "tests/fuzz/fuzzed_server.h"
#include "tests/service/raw_call.h"

namespace procgen {
namespace {

constexpr char kStepPool[] = "/procgen.v1.StepService/StepPool";
constexpr size_t kPiecesMax = 24;

// A stream whose operations are waited for, but for one read that may be under way.
class RawStream {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel)
      : stub_(channel), call_(stub_.PrepareCall(&context_, kStepPool, &queue_)) {
    call_->StartCall(tag(kOther));
    Wait(kOther);
    call_->Read(&response_, tag(kRead));
  }

  bool Write(const std::string& bytes) {
    const grpc::Slice slice(bytes);
    call_->Write(grpc::ByteBuffer(&slice, 1), tag(kOther));
    return Wait(kOther);
  }

  // Waits for a response and checks it; false: there are no more.
  bool Read() {
    if (!Wait(kRead)) {
      is_read_ = true;
      return false;
    }
    Check();
    response_.Clear();
    call_->Read(&response_, tag(kRead));
    return true;
  }

  void Cancel() { context_.TryCancel(); }

  absl::Status Finish() {
    call_->WritesDone(tag(kOther));
    Wait(kOther);
    while (!is_read_ && Read()) {
    }
    grpc::Status status;
    call_->Finish(&status, tag(kOther));
    Wait(kOther);
    return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
  }

 private:
  enum Operation : uint8_t { kRead, kOther, kOperationCount };

  static void* tag(Operation operation) { return reinterpret_cast<void*>(uintptr_t{operation}); }

  // Waits until `operation` has ended, and remembers another that has; returns whether it is ok.
  bool Wait(Operation operation) {
    while (!ended_[operation]) {
      void* ended = nullptr;
      bool ok = false;
      Require(queue_.Next(&ended, &ok), "an operation ends");
      const auto index = reinterpret_cast<uintptr_t>(ended);
      ended_[index] = true;
      ok_[index] = ok;
    }
    ended_[operation] = false;
    return ok_[operation];
  }

  void Check() {
    std::vector<grpc::Slice> slices;
    Require(response_.Dump(&slices).ok(), "a response has bytes");
    std::string bytes;
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
    v1::StepPoolResponse response;
    Require(response.ParseFromString(bytes), "a response is a message");
    Require(is_attached_ != response.has_attached(), "the first response is attached, no other is");
    is_attached_ = true;
    Require(response.sequence_number() >= number_, "answers come in order");
    number_ = response.sequence_number();
  }

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  grpc::ByteBuffer response_;
  bool ended_[kOperationCount] = {};
  bool ok_[kOperationCount] = {};
  bool is_read_ = false;  // to its end
  bool is_attached_ = false;
  int64_t number_ = 0;
};

void Play(const std::vector<Piece>& pieces) {
  FuzzedServer& server = TheFuzzedServer();
  server.ResetPools();
  RawStream stream(server.channel());
  bool open = true;
  for (size_t i = 0; i < pieces.size() && i < kPiecesMax && open; ++i) {
    if (pieces[i].is_mark) {
      stream.Cancel();
      open = false;
    } else {
      open = stream.Write(pieces[i].bytes);
    }
  }
  RequirePromised(stream.Finish());
  server.RequireNoStreams();
  for (const char* pool : {"pools/a", "pools/b"}) {
    v1::StepPoolRequest attach;
    attach.mutable_attach()->set_pool(pool);
    const RawResult again = CallRaw(server.channel(), kStepPool, {attach.SerializeAsString()});
    Require(again.status.ok() && again.responses.size() == 1, "a pool takes another stream",
            again.status);
    server.RequireNoStreams();
  }
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Play(procgen::PiecesOf(bytes, size));
  return 0;
}
