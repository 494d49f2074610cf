// Fuzz target: messages of StepPool streams. An input is pieces (pieces.h), each a message or a
// mark. A mark starts another stream for the following messages; the previous stream stays open,
// for example to be taken over. A second mark in a row cancels the previous stream. At the end,
// half-closes all streams and reads them. Aborts if an error is undocumented, if a response is
// invalid, precedes `attached` or does not belong to the next request, if an ended stream keeps its
// pool, or if the pool accepts no other stream.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "grpcpp/generic/generic_stub.h"
#include "procgen/v1/step.pb.h"
#include "tests/fuzz/fuzzed_server.h"
#include "tests/service/raw_call.h"

namespace procgen {
namespace {

constexpr char kStepPool[] = "/procgen.v1.StepService/StepPool";
constexpr size_t kPiecesMax = 24;
constexpr size_t kStreamsMax = 4;

// A stream with a pending read at all times, so that the server is never blocked. Other operations
// are waited for.
class RawStream {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel)
      : stub_(channel), call_(stub_.PrepareCall(&context_, kStepPool, &queue_)) {
    call_->StartCall(tag(kOther));
    WaitForOther();
    call_->Read(&response_, tag(kRead));
  }

  void Write(const std::string& bytes) {
    if (v1::StepPoolRequest request; request.ParseFromString(bytes)) {
      asked_.push_back(request.sequence_number());
    }
    const grpc::Slice slice(bytes);
    call_->Write(grpc::ByteBuffer(&slice, 1), tag(kOther));
    is_open_ = WaitForOther();
  }

  // Whether the stream accepts more messages.
  bool is_open() const { return is_open_; }

  void Cancel() {
    context_.TryCancel();
    is_open_ = false;
  }

  absl::Status Finish() {
    call_->WritesDone(tag(kOther));
    WaitForOther();
    while (!all_read_) {
      Next();
    }
    grpc::Status status;
    call_->Finish(&status, tag(kOther));
    WaitForOther();
    return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
  }

 private:
  enum Operation : uint8_t { kRead, kOther };

  // NOLINTNEXTLINE(performance-no-int-to-ptr): gRPC's tags are pointers
  static void* tag(Operation operation) { return reinterpret_cast<void*>(uintptr_t{operation}); }

  // Waits for the pending operation other than the read; returns whether it succeeded.
  bool WaitForOther() {
    other_ended_ = false;
    while (!other_ended_) {
      Next();
    }
    return other_ok_;
  }

  // Waits for one operation. Checks a response and starts the next read.
  void Next() {
    void* ended = nullptr;
    bool ok = false;
    Require(queue_.Next(&ended, &ok), "an operation ends");
    if (ended == tag(kOther)) {
      other_ended_ = true;
      other_ok_ = ok;
    } else if (ok) {
      Check();
      response_.Clear();
      call_->Read(&response_, tag(kRead));
    } else {
      all_read_ = true;
    }
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
    Require(!asked_.empty() && response.sequence_number() == asked_.front(),
            "answers come in the order of the requests");
    if (response.has_attached() || response.batch().last()) {
      asked_.pop_front();
    }
  }

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  grpc::ByteBuffer response_;
  bool other_ended_ = false;
  bool other_ok_ = false;
  bool all_read_ = false;
  bool is_open_ = true;
  bool is_attached_ = false;
  std::deque<int64_t> asked_;  // sequence numbers of unanswered requests
};

void Play(const std::vector<Piece>& pieces) {
  FuzzedServer& server = TheFuzzedServer();
  server.ResetPools();
  std::vector<std::unique_ptr<RawStream>> streams;
  streams.push_back(std::make_unique<RawStream>(server.channel()));
  for (size_t i = 0; i < pieces.size() && i < kPiecesMax; ++i) {
    if (!pieces[i].is_mark) {
      if (streams.back()->is_open()) {
        streams.back()->Write(pieces[i].bytes);
      }
    } else if (i > 0 && pieces[i - 1].is_mark && streams.size() > 1) {
      streams[streams.size() - 2]->Cancel();
    } else if (streams.size() < kStreamsMax) {
      streams.push_back(std::make_unique<RawStream>(server.channel()));
    }
  }
  for (const std::unique_ptr<RawStream>& stream : streams) {
    RequirePromised(stream->Finish());
  }
  server.RequireNoStreams();
  for (const char* pool : {"pools/a", "pools/b"}) {
    v1::StepPoolRequest attach;
    attach.mutable_attach()->set_pool(pool);
    attach.mutable_attach()->set_take_over(true);
    RawResult again;
    // The server may handle cancelled streams only now, and each of them may take over once.
    for (size_t tries = 0; tries <= kStreamsMax; ++tries) {
      again = CallRaw(server.channel(), kStepPool, {attach.SerializeAsString()});
      if (!absl::IsAborted(again.status)) {
        break;
      }
    }
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
