// Fuzz target: a server's responses to a session of the C++ client (fuzzed_learner.h). An input is
// one byte of LearnerOptions and pieces (pieces.h). Each piece is the response to the next request
// of any method. On a stream, the next piece follows at once while a batch is incomplete. A mark
// breaks the connection: UNAVAILABLE. After the last piece calls fail with INTERNAL. Aborts where
// RunLearner does.

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/generic/async_generic_service.h"
#include "grpcpp/grpcpp.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/step.pb.h"
#include "tests/fuzz/fuzzed_learner.h"
#include "tests/fuzz/pieces.h"

namespace procgen {
namespace {

constexpr size_t kSharedBytes = 65536;

// The pieces of one input, shared by all calls.
class Answers {
 public:
  explicit Answers(std::vector<Piece> pieces) : pieces_(std::move(pieces)) {}

  // The next piece; null at the end.
  const Piece* Take() {
    const absl::MutexLock lock(&mutex_);
    return taken_ == pieces_.size() ? nullptr : &pieces_[taken_++];
  }

 private:
  const std::vector<Piece> pieces_;
  absl::Mutex mutex_;
  size_t taken_ ABSL_GUARDED_BY(mutex_) = 0;
};

// A call of any method: reads a request, responds, and repeats.
class Call final : public grpc::ServerGenericBidiReactor {
 public:
  enum class Kind : uint8_t { kUnary, kWatch, kStepStream };

  Call(std::shared_ptr<Answers> answers, Kind kind) : answers_(std::move(answers)), kind_(kind) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    const absl::MutexLock lock(&mutex_);
    if (ok) {
      Answer();
    } else {
      Finish(grpc::Status::OK);
    }
  }

  void OnWriteDone(bool ok) override {
    const absl::MutexLock lock(&mutex_);
    if (!ok) {
      Finish(grpc::Status::CANCELLED);
    } else if (is_answer_complete_) {
      StartRead(&request_);
    } else {
      Answer();
    }
  }

  void OnDone() override {
    { const absl::MutexLock lock(&mutex_); }
    delete this;
  }

 private:
  void Answer() {
    const Piece* const piece = answers_->Take();
    if (piece == nullptr) {
      return Finish({grpc::StatusCode::INTERNAL, "no more answers"});
    }
    if (piece->is_mark) {
      return Finish({grpc::StatusCode::UNAVAILABLE, "broken"});
    }
    const grpc::Slice slice(piece->bytes);
    response_ = grpc::ByteBuffer(&slice, 1);
    is_answer_complete_ = kind_ == Kind::kUnary;
    v1::StepPoolResponse response;
    if ((kind_ == Kind::kStepStream && !response.ParseFromString(piece->bytes)) ||
        (kind_ == Kind::kWatch && !v1::WatchPoolResponse().ParseFromString(piece->bytes))) {
      // The client waits 10 s for the end of a stream with invalid responses.
      return StartWriteAndFinish(&response_, {}, {grpc::StatusCode::INTERNAL, "no message"});
    }
    if (kind_ == Kind::kStepStream) {
      is_answer_complete_ = response.has_batch() ? response.batch().last()
                                                 : response.has_attached() || response.has_ack();
    }
    StartWrite(&response_);
  }

  const std::shared_ptr<Answers> answers_;
  const Kind kind_;
  // The callbacks are serialized, but ThreadSanitizer cannot see that in a generic service, which
  // runs within the library.
  absl::Mutex mutex_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  bool is_answer_complete_ = false;
};

// A server that responds to all methods with the pieces of an input.
class HostileServer final : public grpc::CallbackGenericService {
 public:
  HostileServer() {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterCallbackGenericService(this);
    server_ = builder.BuildAndStart();
    Require(server_ != nullptr && port != 0, "there is a server");
    channel_ =
        grpc::CreateChannel(absl::StrCat("127.0.0.1:", port), grpc::InsecureChannelCredentials());
    ShareMemory();
  }

  void Play(uint8_t options, std::vector<Piece> pieces) {
    {
      const absl::MutexLock lock(&mutex_);
      answers_ = std::make_shared<Answers>(std::move(pieces));
    }
    RunLearner(channel_, LearnerOptions(options));
  }

  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    const absl::MutexLock lock(&mutex_);
    return new Call(answers_,
                    absl::EndsWith(context->method(), "/StepPool")    ? Call::Kind::kStepStream
                    : absl::EndsWith(context->method(), "/WatchPool") ? Call::Kind::kWatch
                                                                      : Call::Kind::kUnary);
  }

 private:
  // Opens the file that responses name as the pool's shared memory. Nearly all bytes, including
  // flags, are neither 0 nor 1.
  static void ShareMemory() {
    const int file = memfd_create("answers", MFD_CLOEXEC);
    std::string bytes(kSharedBytes, '\0');
    for (size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<char>(i * 31);
    }
    Require(file >= 0 && write(file, bytes.data(), bytes.size()) == ssize_t{kSharedBytes} &&
                dup2(file, kSharedFile) == kSharedFile,
            "there is shared memory");
  }

  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  absl::Mutex mutex_;
  std::shared_ptr<Answers> answers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static procgen::HostileServer& server = *new procgen::HostileServer;
  if (size > 0) {
    server.Play(bytes[0], procgen::PiecesOf(bytes + 1, size - 1));
  }
  return 0;
}
