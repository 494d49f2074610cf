#include "server/rpc/bridge/generic_stub.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/client_callback.h"

namespace procgen {
namespace {

// Longest method and token: both are metadata, of which the server accepts 8 KiB.
constexpr size_t kMethodBytesMax = 256;
constexpr size_t kTokenBytesMax = 2048;

// Whether gRPC accepts `text` as a value of metadata: on others it ends the process.
bool IsMetadata(absl::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](unsigned char letter) { return absl::ascii_isprint(letter); });
}

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::string bytes;
  bytes.reserve(buffer.Length());
  std::vector<grpc::Slice> slices;
  if (buffer.Dump(&slices).ok()) {
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
  }
  return bytes;
}

// A call. Keeps itself until OnDone. A hold of gRPC's allows to start operations outside of its
// reactions; it is removed when a read fails or the call is cancelled.
class Call final : public GenericCall,
                   public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                   public std::enable_shared_from_this<Call> {
 public:
  // `counted`: kept until the end.
  Call(std::shared_ptr<GenericCallObserver> observer, std::shared_ptr<const void> counted)
      : observer_(std::move(observer)), counted_(std::move(counted)) {}

  void Start(grpc::GenericStub* stub, const std::string& method, const std::string& token) {
    self_ = shared_from_this();
    if (!token.empty()) {
      context_.AddMetadata("authorization", absl::StrCat("Bearer ", token));
    }
    stub->PrepareBidiStreamingCall(&context_, method, grpc::StubOptions(), this);
    AddHold();
    StartCall();
  }

  void Read() override {
    WithHold([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { is_reading_ = true; },
             [this] { StartRead(&received_); });
  }

  void Write(const std::string& message) override {
    WithHold([] {},
             [this, &message] {
               const grpc::Slice slice(message);
               sent_ = grpc::ByteBuffer(&slice, 1);
               StartWrite(&sent_);
             });
  }

  void HalfClose() override {
    WithHold([] {}, [this] { StartWritesDone(); });
  }

  void Cancel() override {
    bool has_ended = false;
    {
      absl::MutexLock lock(&mutex_);
      is_cancelled_ = true;
      has_ended = !is_reading_ && !std::exchange(is_over_, true);
    }
    context_.TryCancel();
    if (has_ended) {
      RemoveHold();
    }
  }

 private:
  // Calls `prepare` and then, without the lock, `start`, which starts an operation of gRPC's. No
  // effect once the call is over.
  template <typename Prepare, typename Begin>
  void WithHold(Prepare prepare, Begin start) ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      absl::MutexLock lock(&mutex_);
      if (is_over_) {
        return;
      }
      prepare();
      AddHold();
    }
    start();
    RemoveHold();
  }

  void OnReadDone(bool ok) override {
    bool has_ended = false;
    {
      absl::MutexLock lock(&mutex_);
      is_reading_ = false;
      has_ended = (!ok || is_cancelled_) && !std::exchange(is_over_, true);
    }
    if (ok) {
      std::string message = BytesOf(received_);
      received_.Clear();
      observer_->OnMessage(std::move(message));
    }
    if (has_ended) {
      RemoveHold();
    }
  }

  void OnWriteDone(bool ok) override {
    sent_.Clear();
    if (ok) {
      observer_->OnWritten();
    }
  }

  void OnDone(const grpc::Status& status) override {
    CallEnd end;
    end.status =
        absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
    end.is_draining = context_.GetServerTrailingMetadata().contains("procgen-drains");
    std::exchange(observer_, nullptr)->OnEnd(end);
    counted_ = nullptr;
    const std::shared_ptr<Call> last = std::move(self_);
  }

  std::shared_ptr<GenericCallObserver> observer_;
  std::shared_ptr<const void> counted_;
  std::shared_ptr<Call> self_;
  grpc::ClientContext context_;
  grpc::ByteBuffer received_;  // by the read in progress
  grpc::ByteBuffer sent_;      // by the write in progress

  absl::Mutex mutex_;
  bool is_reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_over_ ABSL_GUARDED_BY(mutex_) = false;  // no further operation is started
};

class ChannelStub final : public GenericStub {
 public:
  explicit ChannelStub(const std::shared_ptr<grpc::Channel>& channel) : stub_(channel) {}

  ~ChannelStub() override {
    absl::MutexLock lock(&mutex_);
    const auto have_ended = [this]()
                                ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return call_count_ == 0; };
    mutex_.Await(absl::Condition(&have_ended));
  }

  absl::StatusOr<std::shared_ptr<GenericCall>> Start(
      const std::string& method, const std::string& token,
      std::shared_ptr<GenericCallObserver> observer) override {
    if (!absl::StartsWith(method, "/") || method.size() > kMethodBytesMax || !IsMetadata(method)) {
      return absl::InvalidArgumentError(
          absl::StrCat("the method is no path /PACKAGE.SERVICE/METHOD of at most ", kMethodBytesMax,
                       " printable ASCII characters"));
    }
    if (token.size() > kTokenBytesMax || !IsMetadata(token)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the token is no text of at most ", kTokenBytesMax, " printable ASCII characters"));
    }
    {
      absl::MutexLock lock(&mutex_);
      ++call_count_;
    }
    const std::shared_ptr<const void> counted(this, [](ChannelStub* stub) {
      absl::MutexLock lock(&stub->mutex_);
      --stub->call_count_;
    });
    const auto call = std::make_shared<Call>(std::move(observer), counted);
    call->Start(&stub_, method, token);
    return call;
  }

 private:
  grpc::GenericStub stub_;
  absl::Mutex mutex_;
  int64_t call_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace

std::unique_ptr<GenericStub> MakeGenericStub(const std::shared_ptr<grpc::Channel>& channel) {
  return std::make_unique<ChannelStub>(channel);
}

}  // namespace procgen
