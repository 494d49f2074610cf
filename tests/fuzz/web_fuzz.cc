// Fuzz target: messages of a page. An input is pieces (pieces.h), each a text message or, after a
// mark, a binary one. A page session executes them with the real services. Aborts if a message gets
// neither a response nor the end of the socket, if a response is not JSON, has no id or an
// undocumented error, or if pools remain after the page is closed.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/synchronization/mutex.h"
#include "procgen_client/client.h"
#include "server/concurrency/thread_group.h"
#include "server/web/session/page_session.h"
#include "server/web/session/pool_feed.h"
#include "tests/fuzz/fuzzed_server.h"

namespace procgen {
namespace {

// Fewer than the rate limit's burst.
constexpr size_t kPiecesMax = 24;
constexpr size_t kThreadsMax = 64;

// The header of a message.
web::Json HeaderOf(const web::WireMessage& message) {
  absl::string_view text = message.bytes;
  if (message.is_binary) {
    uint32_t length = 0;
    Require(text.size() >= sizeof(length), "a binary message has a length");
    std::memcpy(&length, text.data(), sizeof(length));
    Require(length <= text.size() - sizeof(length), "a binary message has a header");
    text = text.substr(sizeof(length), length);
  }
  return web::Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
}

// A socket that checks outgoing messages and waits for responses.
class CheckedOutbox final : public web::Outbox {
 public:
  void Answer(web::WireMessage message) override {
    const web::Json header = HeaderOf(message);
    Require(header.is_object() && header.contains("id"), "an answer has an id");
    Require(header.contains("result") != header.contains("error"),
            "an answer has a result or an error");
    if (header.contains("error")) {
      Require(header["error"]["code"] != "INTERNAL" && header["error"]["code"] != "UNKNOWN",
              header.dump());
      Require(!header["error"]["message"].get<std::string>().empty(),
              "an error says what is wrong");
    }
    absl::MutexLock lock(&mutex_);
    ++answer_count_;
  }
  void SendEvent(web::WireMessage message) override {
    Require(HeaderOf(message).contains("event"), "an event has a name");
  }
  void SendLatestEvent(const std::string& /*key*/, web::WireMessage message) override {
    SendEvent(std::move(message));
  }
  void SendFrames(const std::string& /*key*/,
                  absl::AnyInvocable<web::WireMessage()> compose) override {
    SendEvent(compose());
  }
  void DropEvent(const std::string& /*key*/) override {}
  void AcceptHello() override {}
  void Close(int /*code*/, std::string reason) override {
    Require(!reason.empty(), "the end of a socket has a reason");
    absl::MutexLock lock(&mutex_);
    is_closed_ = true;
  }

  // Waits until `count` messages are answered or the socket is closed.
  void Await(size_t count) {
    absl::MutexLock lock(&mutex_);
    const auto is_done = [this, count]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return is_closed_ || answer_count_ == count;
    };
    mutex_.Await(absl::Condition(&is_done));
  }

 private:
  absl::Mutex mutex_;
  size_t answer_count_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
};

// The context of a page session. Destroyed after it.
struct Dependencies {
  web::PoolFeed feed{[] { return std::vector<web::PoolReport>(); }};
  ThreadGroup watch_threads{kThreadsMax, "no room for another watch"};
  web::DifferenceCache differences;
  web::PageSessionContext context{
      .version = "fuzzed",
      .requires_token = false,
      .viewers_max = 1,
      .connect =
          [](const std::string& token) {
            return procgen_client::Client::FromChannel(TheFuzzedServer().channel(), token);
          },
      .report_episodes = [](const std::string&, const std::string&,
                            int64_t) { return web::EpisodeList(); },
      .pause_pool = [](const std::string&, const std::string&) -> std::unique_ptr<web::PoolPause> {
        return nullptr;
      },
      .feed = &feed,
      .watch_threads = &watch_threads,
      .differences = &differences};
};

void Play(const std::vector<Piece>& pieces) {
  LivePool& pool = TheLivePool();
  Dependencies dependencies;
  const auto outbox = std::make_shared<CheckedOutbox>();
  const auto page_session = std::make_shared<web::PageSession>(dependencies.context, outbox);
  std::thread thread([page_session] { page_session->Run(); });
  page_session->Take({R"({"id":0,"method":"hello"})", false});
  size_t count = 1;
  bool is_binary = false;
  for (size_t i = 0; i < pieces.size() && i < kPiecesMax; ++i) {
    if (!pieces[i].is_mark) {
      page_session->Take({pieces[i].bytes, is_binary});
      ++count;
    }
    is_binary = pieces[i].is_mark;
  }
  outbox->Await(count);
  page_session->Stop();
  thread.join();
  TheFuzzedServer().RequirePoolCount(1);
  pool.Step();
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::Play(procgen::PiecesOf(bytes, size));
  return 0;
}
