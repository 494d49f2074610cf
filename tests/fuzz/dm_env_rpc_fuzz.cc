// Fuzz target: messages of dm_env_rpc streams. An input is pieces (pieces.h), each a message or a
// mark. Sends each message and waits for its response. A mark starts another stream for the
// following messages; the previous stream stays open. A second mark in a row cancels the previous
// stream. Aborts if a message has no response, an invalid one or an undocumented error, if a stream
// ends by itself, or if an ended stream keeps its world.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dm_env_rpc/v1/dm_env_rpc.pb.h"
#include "grpcpp/generic/generic_stub.h"
#include "tests/fuzz/fuzzed_server.h"

namespace procgen {
namespace {

namespace dm = ::dm_env_rpc::v1;

constexpr char kProcess[] = "/dm_env_rpc.v1.Environment/Process";
constexpr size_t kPiecesMax = 24;
constexpr size_t kStreamsMax = 4;

// Whether a request waits for another stream's step. That would block, because only one stream is
// active.
bool WaitsForOthers(const std::string& bytes) {
  dm::EnvironmentRequest request;
  return request.ParseFromString(bytes) && request.has_reset_world();
}

class RawStream {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel)
      : stub_(channel), call_(stub_.PrepareCall(&context_, kProcess, &queue_)) {
    call_->StartCall(nullptr);
    Require(Wait(), "a stream begins");
  }

  void Ask(const std::string& bytes) {
    const grpc::Slice slice(bytes);
    call_->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    Require(Wait(), "a stream takes messages");
    grpc::ByteBuffer response;
    call_->Read(&response, nullptr);
    Require(Wait(), "a message is answered");
    Check(response);
  }

  void Cancel() {
    context_.TryCancel();
    cancelled_ = true;
  }

  void Finish() {
    call_->WritesDone(nullptr);
    Wait();
    grpc::Status status;
    call_->Finish(&status, nullptr);
    Wait();
    Require(status.ok() || cancelled_, "a stream ends well");
  }

 private:
  // Waits for the pending operation.
  bool Wait() {
    void* ended = nullptr;
    bool ok = false;
    Require(queue_.Next(&ended, &ok), "an operation ends");
    return ok;
  }

  static void Check(const grpc::ByteBuffer& response) {
    std::vector<grpc::Slice> slices;
    Require(response.Dump(&slices).ok(), "a response has bytes");
    std::string bytes;
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
    dm::EnvironmentResponse message;
    Require(message.ParseFromString(bytes), "a response is a message");
    Require(message.payload_case() != dm::EnvironmentResponse::PAYLOAD_NOT_SET,
            "a response answers");
    if (message.has_error()) {
      const auto code = static_cast<absl::StatusCode>(message.error().code());
      Require(code != absl::StatusCode::kOk, "an error has a code");
      RequirePromised(absl::Status(code, message.error().message()));
    }
  }

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  bool cancelled_ = false;
};

void Play(const std::vector<Piece>& pieces) {
  FuzzedServer& server = TheFuzzedServer();
  server.ResetPools();
  std::vector<std::unique_ptr<RawStream>> streams;
  streams.push_back(std::make_unique<RawStream>(server.channel()));
  bool last_is_cancelled = false;
  for (size_t i = 0; i < pieces.size() && i < kPiecesMax; ++i) {
    if (!pieces[i].is_mark) {
      if (streams.size() == 1 || !WaitsForOthers(pieces[i].bytes)) {
        streams.back()->Ask(pieces[i].bytes);
      }
    } else if (i > 0 && pieces[i - 1].is_mark && streams.size() > 1 && !last_is_cancelled) {
      streams[streams.size() - 2]->Cancel();
      last_is_cancelled = true;
    } else if (streams.size() < kStreamsMax) {
      streams.push_back(std::make_unique<RawStream>(server.channel()));
      last_is_cancelled = false;
    }
  }
  for (const std::unique_ptr<RawStream>& stream : streams) {
    stream->Finish();
  }
  server.RequireNoStreams();
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Play(procgen::PiecesOf(bytes, size));
  return 0;
}
