// Fuzz target: messages of RunPool streams. An input is pieces (pieces.h), each a message or a
// mark. A mark starts another stream for the following messages; the previous stream stays open. A
// second mark in a row cancels the previous stream. At the end, half-closes all streams and reads
// them. Aborts if an error is undocumented, if a response is invalid or does not answer the next
// request, if a stream ends with OK before it answered all requests, or with an error though it
// answered all, if a pool outlives its stream, or if no further pool can be started.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "grpcpp/generic/generic_stub.h"
#include "procgen/v1/run.pb.h"
#include "tests/fuzz/fuzzed_server.h"
#include "tests/service/raw_call.h"
#include "zstd.h"

namespace procgen {
namespace {

constexpr size_t kPiecesMax = 24;
constexpr size_t kStreamsMax = 4;

using Kind = v1::RunPoolResponse::ResponseCase;

// The kind of response that answers `request`.
Kind KindOf(const v1::RunPoolRequest& request) {
  switch (request.request_case()) {
    case v1::RunPoolRequest::kStart:
      return Kind::kStarted;
    case v1::RunPoolRequest::kStep:
      return request.step().acknowledge_only() ? Kind::kAck : Kind::kBatch;
    case v1::RunPoolRequest::kReset:
      return request.reset().acknowledge_only() ? Kind::kAck : Kind::kBatch;
    case v1::RunPoolRequest::kObserve:
      return Kind::kBatch;
    case v1::RunPoolRequest::kSaveStates:
      return Kind::kStates;
    case v1::RunPoolRequest::kRender:
      return Kind::kFrames;
    case v1::RunPoolRequest::kRestoreStates:
    case v1::RunPoolRequest::kCloneStates:
    case v1::RunPoolRequest::kLevelSampler:
      return Kind::kAck;
    default:
      return Kind::RESPONSE_NOT_SET;
  }
}

const v1::Slice& SliceOf(const v1::RunPoolRequest& request) {
  return request.has_step()    ? request.step().slice()
         : request.has_reset() ? request.reset().slice()
                               : request.observe().slice();
}

// Checks a batch of the pool `pool` that answers a step, reset or observe.
void CheckBatch(const v1::Pool& pool, const v1::RunPoolRequest& request, const v1::Batch& batch) {
  const v1::Slice& slice = SliceOf(request);
  const int32_t rows = slice.env_count();
  Require(batch.first_env() == slice.first_env() && batch.env_count() == rows,
          "a batch has the rows of its request");
  for (const int size :
       {batch.rewards_size(), batch.first_size(), batch.terminated_size(), batch.truncated_size(),
        batch.level_seeds_size(), batch.prev_level_seeds_size(), batch.prev_level_complete_size(),
        batch.episode_returns_size(), batch.episode_lengths_size()}) {
    Require(size == rows, "an array has a row for each environment");
  }
  size_t ended = 0;
  for (int row = 0; row < rows; ++row) {
    ended += batch.terminated(row) || batch.truncated(row) ? 1 : 0;
  }
  const auto observation_bytes = static_cast<size_t>(pool.observation_bytes());
  const bool has_finals = request.step().with_final_observations();
  Require(static_cast<size_t>(batch.fingerprints_size()) == ended,
          "there is a fingerprint for each ended episode");
  Require(batch.final_observations().size() == (has_finals ? ended * observation_bytes : 0) ||
              (batch.final_observations().empty() &&
               pool.spec().autoreset_mode() != v1::AUTORESET_MODE_SAME_STEP),
          "final observations have their size");
  const std::string& observations = batch.observations();
  const size_t bytes = static_cast<size_t>(rows) * observation_bytes;
  Require(observations.empty() || pool.spec().encoding() != v1::ENCODING_RAW ||
              observations.size() == bytes,
          "observations have their size");
  Require(observations.empty() || pool.spec().encoding() == v1::ENCODING_RAW ||
              ZSTD_getFrameContentSize(observations.data(), observations.size()) == bytes,
          "encoded observations have their size");
}

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  Require(buffer.Dump(&slices).ok(), "a response has bytes");
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// A stream with a pending read at all times, so that the server is never blocked. Other operations
// are waited for.
class RawStream {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel)
      : stub_(channel), call_(stub_.PrepareCall(&context_, kRunPool, &queue_)) {
    call_->StartCall(tag(kOther));
    WaitForOther();
    call_->Read(&response_, tag(kRead));
  }

  void Write(const std::string& bytes) {
    if (!is_open_) {
      return;
    }
    v1::RunPoolRequest request;
    has_garbage_ |= !request.ParseFromString(bytes);
    if (!has_garbage_) {
      asked_.push_back(std::move(request));
    }
    const grpc::Slice slice(bytes);
    call_->Write(grpc::ByteBuffer(&slice, 1), tag(kOther));
    is_open_ = WaitForOther();
  }

  void Cancel() {
    context_.TryCancel();
    is_open_ = false;
    is_cancelled_ = true;
  }

  // Reads the stream to its end and checks its status.
  void Finish() {
    call_->WritesDone(tag(kOther));
    WaitForOther();
    while (!all_read_) {
      Next();
    }
    grpc::Status end;
    call_->Finish(&end, tag(kOther));
    WaitForOther();
    const absl::Status status(static_cast<absl::StatusCode>(end.error_code()), end.error_message());
    RequirePromised(status);
    Require(is_cancelled_ || !absl::IsCancelled(status), "only a client cancels", status);
    Require(is_cancelled_ || status.ok() == (asked_.empty() && !has_garbage_),
            "a stream ends with an error at the first request that it does not answer", status);
    Require(is_cancelled_ || asked_.empty() ||
                !absl::StrContains(status.message(), "bytes are not a valid"),
            "a stream ends with the error of the first request at fault", status);
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
    v1::RunPoolResponse response;
    Require(response.ParseFromString(BytesOf(response_)), "a response is a message");
    Require(!asked_.empty(), "a response answers a request");
    Require(response.response_case() != Kind::RESPONSE_NOT_SET &&
                response.response_case() == KindOf(asked_.front()),
            "a response has the kind that its request asks for");
    if (response.has_started()) {
      pool_ = response.started().pool();
    } else if (response.has_batch()) {
      CheckBatch(pool_, asked_.front(), response.batch());
    }
    asked_.pop_front();
  }

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  grpc::ByteBuffer response_;
  bool other_ended_ = false;
  bool other_ok_ = false;
  bool all_read_ = false;
  bool is_open_ = true;  // the stream accepts more messages
  bool is_cancelled_ = false;
  bool has_garbage_ = false;  // bytes that are not a message were sent
  v1::Pool pool_;
  std::deque<v1::RunPoolRequest> asked_;  // unanswered requests before any garbage
};

void Play(const std::vector<Piece>& pieces) {
  FuzzedServer& server = TheFuzzedServer();
  std::vector<std::unique_ptr<RawStream>> streams;
  streams.push_back(std::make_unique<RawStream>(server.channel()));
  for (size_t i = 0; i < pieces.size() && i < kPiecesMax; ++i) {
    if (!pieces[i].is_mark) {
      streams.back()->Write(pieces[i].bytes);
    } else if (i > 0 && pieces[i - 1].is_mark && streams.size() > 1) {
      streams[streams.size() - 2]->Cancel();
    } else if (streams.size() < kStreamsMax) {
      streams.push_back(std::make_unique<RawStream>(server.channel()));
    }
  }
  for (const std::unique_ptr<RawStream>& stream : streams) {
    stream->Finish();
  }
  server.RequirePoolCount(0);
  v1::RunPoolRequest start;
  start.mutable_start()->mutable_spec()->add_games("maze");
  start.mutable_start()->mutable_spec()->set_env_count(1);
  const RawResult again = CallRaw(server.channel(), kRunPool, {start.SerializeAsString()});
  Require(again.status.ok() && again.responses.size() == 1, "another pool starts", again.status);
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Play(procgen::PiecesOf(bytes, size));
  return 0;
}
