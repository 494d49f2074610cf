// Fuzz target: messages of a page. An input is pieces (pieces.h), each a message of the bridge. A
// session executes them with the real services. Aborts if a message to the page is not a
// BridgeResponse of a call that it opened, if a call ends twice or with an undocumented error, if a
// socket is closed without a reason, or if calls or pools remain after the page is closed.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/synchronization/mutex.h"
#include "procgen/web/v1/bridge.pb.h"
#include "server/rpc/bridge/generic_stub.h"
#include "server/web/bridge/bridge_session.h"
#include "tests/fuzz/fuzzed_server.h"

namespace procgen {
namespace {

constexpr size_t kPiecesMax = 64;
// A call of the target itself: it is answered after the calls before it were accepted.
constexpr uint32_t kFence = 4'000'000'000;

// What a strand is for the session: functions that other threads post, run one at a time.
class Queue {
 public:
  void Post(absl::AnyInvocable<void()> work) {
    absl::MutexLock lock(&mutex_);
    queue_.push_back(std::move(work));
  }
  // Waits for the next function and runs it.
  void RunOne() {
    absl::AnyInvocable<void()> work;
    {
      const auto has_work = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !queue_.empty(); };
      absl::MutexLock lock(&mutex_, absl::Condition(&has_work));
      work = std::move(queue_.front());
      queue_.pop_front();
    }
    work();
  }

 private:
  absl::Mutex mutex_;
  std::deque<absl::AnyInvocable<void()>> queue_ ABSL_GUARDED_BY(mutex_);
};

// A page with a socket that is always writable.
class Page {
 public:
  explicit Page(GenericStub* stub)
      : session_(std::make_shared<web::BridgeSession>(
            stub,
            [queue = queue_](absl::AnyInvocable<void()> work) { queue->Post(std::move(work)); },
            [] {})) {}
  ~Page() { session_->Stop(); }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  // Sends a message. Returns false if the socket is closed.
  bool Send(const std::string& bytes) {
    web::v1::BridgeRequest request;
    const bool opens = request.ParseFromString(bytes) && request.has_method();
    const std::optional<web::CloseReason> reason = session_->Take(bytes);
    if (reason.has_value()) {
      Require(reason->code >= web::kCloseGoingAway && !reason->text.empty(),
              "the end of a socket has a reason");
      return false;
    }
    if (opens) {
      Require(open_.insert(request.call()).second, "a call in use is not opened again");
    }
    return true;
  }

  bool CanSend() const { return session_->CanTake(); }

  // Receives messages until a call has ended.
  void AwaitEnd(uint32_t call) {
    Receive();
    while (open_.contains(call)) {
      queue_->RunOne();
      Receive();
    }
  }

 private:
  void Receive() {
    while (const std::optional<std::string> bytes = session_->Next()) {
      session_->OnWritten();
      web::v1::BridgeResponse response;
      Require(response.ParseFromString(*bytes), "a message is a BridgeResponse");
      Require(open_.contains(response.call()), "a message belongs to an open call");
      if (response.has_end()) {
        open_.erase(response.call());
        const web::v1::Status& end = response.end();
        const auto code = static_cast<absl::StatusCode>(end.code());
        Require(code != absl::StatusCode::kInternal && code != absl::StatusCode::kUnknown,
                end.message());
      }
    }
  }

  const std::shared_ptr<Queue> queue_ = std::make_shared<Queue>();  // calls may end after this
  const std::shared_ptr<web::BridgeSession> session_;
  std::set<uint32_t> open_;
};

std::string Request(uint32_t call, absl::string_view method) {
  web::v1::BridgeRequest request;
  request.set_call(call);
  request.set_method(std::string(method));
  return request.SerializeAsString();
}

void Play(const std::vector<Piece>& pieces) {
  LivePool& pool = TheLivePool();
  const std::unique_ptr<GenericStub> stub = MakeGenericStub(TheFuzzedServer().channel());
  {
    Page page(stub.get());
    bool is_open = true;
    for (size_t i = 0; is_open && i < pieces.size() && i < kPiecesMax && page.CanSend(); ++i) {
      if (!pieces[i].is_mark) {
        is_open = page.Send(pieces[i].bytes);
      } else if ((is_open = page.Send(Request(kFence, "/none")))) {
        page.AwaitEnd(kFence);
      }
    }
    if (is_open && page.CanSend() && page.Send(Request(kFence, "/none"))) {
      page.AwaitEnd(kFence);
    }
  }
  TheFuzzedServer().RequirePoolCount(1);
  pool.Step();
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Play(procgen::PiecesOf(bytes, size));
  return 0;
}
