// Fuzz target: messages of a page. An input is pieces (pieces.h), each a BridgeRequest; a mark
// waits until the calls have nothing to report. A bridge session executes them with the real
// services. Aborts if a message to the page is no BridgeResponse or belongs to no call, if a call
// ends with an undocumented error or a socket without a reason, or if pools remain after the page.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "procgen/web/v1/bridge.pb.h"
#include "server/rpc/bridge/generic_stub.h"
#include "server/web/bridge/bridge_session.h"
#include "tests/fuzz/fuzzed_server.h"

namespace procgen {
namespace {

constexpr size_t kPiecesMax = 64;
// Calls that report nothing for this long wait for the page.
constexpr absl::Duration kQuiet = absl::Milliseconds(20);

// Runs functions that other threads post, on the thread of the target.
class Strand {
 public:
  void Post(absl::AnyInvocable<void()> function) {
    absl::MutexLock lock(&mutex_);
    posted_.push_back(std::move(function));
  }

  // Runs what was posted, waiting up to `timeout` for the first. Returns whether there was any.
  bool Run(absl::Duration timeout) {
    std::deque<absl::AnyInvocable<void()>> functions;
    {
      absl::MutexLock lock(&mutex_);
      const auto has_any = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !posted_.empty(); };
      mutex_.AwaitWithTimeout(absl::Condition(&has_any), timeout);
      functions.swap(posted_);
    }
    for (absl::AnyInvocable<void()>& function : functions) {
      function();
    }
    return !functions.empty();
  }

 private:
  absl::Mutex mutex_;
  std::deque<absl::AnyInvocable<void()>> posted_ ABSL_GUARDED_BY(mutex_);
};

void CheckMessage(const std::string& bytes) {
  web::v1::BridgeResponse response;
  Require(response.ParseFromString(bytes), "a message to the page is a BridgeResponse");
  Require(response.call() != 0, "a message to the page belongs to a call");
  Require(response.has_message() || response.has_end(), "a response is of a known kind");
  if (response.has_end() && response.end().code() != 0) {
    const absl::Status status(static_cast<absl::StatusCode>(response.end().code()),
                              response.end().message());
    Require(!absl::IsInternal(status) && !absl::IsUnknown(status), "an error is documented",
            status);
    Require(!status.message().empty(), "an error says what is wrong", status);
  }
}

// Runs the session until it reports nothing for some time.
void Settle(web::BridgeSession* session, Strand* strand) {
  do {
    while (std::optional<std::string> message = session->Next()) {
      CheckMessage(*message);
      session->OnWritten();
    }
  } while (strand->Run(kQuiet));
}

void Play(const std::vector<Piece>& pieces) {
  LivePool& pool = TheLivePool();
  Strand strand;
  std::unique_ptr<GenericStub> stub = MakeGenericStub(TheFuzzedServer().channel());
  auto session = std::make_shared<web::BridgeSession>(
      stub.get(),
      [&strand](absl::AnyInvocable<void()> function) { strand.Post(std::move(function)); }, [] {});
  for (size_t i = 0; i < pieces.size() && i < kPiecesMax; ++i) {
    if (pieces[i].is_mark || !session->CanTake()) {
      Settle(session.get(), &strand);
    }
    if (!session->CanTake()) {
      break;  // a call that takes nothing, such as one of a stream that the server does not read
    }
    if (pieces[i].is_mark) {
      continue;
    }
    if (const std::optional<web::CloseReason> reason = session->Take(pieces[i].bytes)) {
      Require(!reason->text.empty() && reason->code >= 1000, "the end of a socket has a reason");
      break;
    }
  }
  Settle(session.get(), &strand);
  session->Stop();
  std::thread([&stub] { stub.reset(); }).join();
  while (strand.Run(absl::ZeroDuration())) {
  }
  session.reset();
  TheFuzzedServer().RequirePoolCount(1);
  pool.Step();
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Play(procgen::PiecesOf(bytes, size));
  return 0;
}
