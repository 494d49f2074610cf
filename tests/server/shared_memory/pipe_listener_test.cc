#include "server/shared_memory/pipe_listener.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/shared_memory/file_descriptor.h"
#include "tests/server/shared_memory/learner_pipe_ends.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr size_t kMessageBytesMax = 10'000;
// More than the limit on connections without a key.
constexpr int kConnectionCount = 100;

// A message with its length prefix.
std::string Framed(const std::string& message) {
  const auto length = static_cast<uint32_t>(message.size());
  std::string bytes(sizeof(length), '\0');
  std::memcpy(bytes.data(), &length, sizeof(length));
  return bytes + message;
}

// A learner that sends and receives raw bytes.
class RawLearner {
 public:
  explicit RawLearner(const PipeListener& listener)
      : socket_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    const std::string& name = listener.socket_name();
    std::copy(name.begin(), name.end(), address.sun_path + 1);
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    connected_ = connect(socket_.number(), reinterpret_cast<const sockaddr*>(&address), size) == 0;
  }
  bool connected() const { return connected_; }
  // Sends a key; returns whether it is accepted.
  bool SendKey(const std::string& key) {
    // A rejected connection may already be closed here.
    if (send(socket_.number(), key.data(), key.size(), MSG_NOSIGNAL) == ssize_t(key.size())) {
      ends_ = LearnerPipeEnds::Receive(socket_.number());
    }
    return ends_.has_value();
  }
  // Whether the server closes the connection before a key was sent.
  bool IsClosedByServer() const {
    char byte = 0;
    return recv(socket_.number(), &byte, 1, 0) == 0;
  }
  void Send(const std::string& bytes) const {
    ASSERT_EQ(write(ends_->requests.number(), bytes.data(), bytes.size()), ssize_t(bytes.size()));
  }
  // Reads until the pipe is closed or `count` bytes arrived.
  std::string Receive(size_t count = SIZE_MAX) const {
    std::string received;
    char byte = 0;
    while (received.size() < count && read(ends_->responses.number(), &byte, 1) == 1) {
      received.push_back(byte);
    }
    return received;
  }

 private:
  const FileDescriptor socket_;
  bool connected_ = false;
  std::optional<LearnerPipeEnds> ends_;
};

// Records messages and answers each with "re: " and its text. Closes the pipes after the tenth.
class Stream final : public PipeConnectionUser {
 public:
  void OnPipesOpened(std::shared_ptr<PipeConnection> pipes) override {
    {
      absl::MutexLock lock(&mutex_);
      pipes_ = std::move(pipes);
    }
    OnPipesInput();
  }
  void OnPipesInput() override {
    absl::MutexLock lock(&mutex_);
    while (pipes_ != nullptr) {
      const auto message = pipes_->Receive();
      if (message.ok() && !message->has_value()) {
        pipes_->Watch();
        return;
      }
      if (message.ok()) {
        received_.emplace_back(**message);
        pipes_->Send({"re: ", **message});
      } else {
        end_ = message.status();
      }
      if (!message.ok() || received_.size() == 10) {
        pipes_->HangUp();
        pipes_ = nullptr;
      }
    }
  }

  std::vector<std::string> received() {
    absl::MutexLock lock(&mutex_);
    return received_;
  }
  // Waits for the end of the pipes; returns the reason.
  absl::Status WaitForEnd() {
    const auto has_ended = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !end_.ok(); };
    absl::MutexLock lock(&mutex_, absl::Condition(&has_ended));
    return end_;
  }

 private:
  absl::Mutex mutex_;
  std::shared_ptr<PipeConnection> pipes_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::string> received_ ABSL_GUARDED_BY(mutex_);
  absl::Status end_ ABSL_GUARDED_BY(mutex_);
};

class PipeListenerTest : public testing::Test {
 protected:
  std::unique_ptr<PipeListener> listener_ = *PipeListener::Open(kMessageBytesMax);
  std::shared_ptr<Stream> stream_ = std::make_shared<Stream>();
};

TEST_F(PipeListenerTest, MessagesGoBothWays) {
  const std::string key = listener_->Expect(stream_);
  EXPECT_EQ(key.size(), PipeListener::kKeyBytes);
  const std::string large(kMessageBytesMax, 'x');
  {
    RawLearner learner(*listener_);
    ASSERT_TRUE(learner.SendKey(key));
    learner.Send(Framed("one") + Framed("") + Framed("two").substr(0, 5));
    const std::string first = Framed("re: one") + Framed("re: ");
    EXPECT_EQ(learner.Receive(first.size()), first);
    learner.Send(Framed("two").substr(5) + Framed(large));
    const std::string second = Framed("re: two") + Framed("re: " + large);
    EXPECT_EQ(learner.Receive(second.size()), second);
  }
  EXPECT_THAT(stream_->WaitForEnd(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
  EXPECT_THAT(stream_->received(), ElementsAre("one", "", "two", large));
}

TEST_F(PipeListenerTest, ConnectionWithoutKeyIsRejected) {
  const std::string key = listener_->Expect(stream_);
  for (const std::string& wrong :
       {std::string(PipeListener::kKeyBytes, 'x'), key.substr(1) + "x"}) {
    RawLearner learner(*listener_);
    EXPECT_FALSE(learner.SendKey(wrong));
  }
  EXPECT_THAT(stream_->received(), IsEmpty());
}

TEST_F(PipeListenerTest, KeyWorksOnce) {
  const std::string key = listener_->Expect(stream_);
  RawLearner first(*listener_);
  ASSERT_TRUE(first.SendKey(key));
  first.Send(Framed("first"));
  EXPECT_EQ(first.Receive(8), Framed("re: first").substr(0, 8));
  RawLearner second(*listener_);
  EXPECT_FALSE(second.SendKey(key));
  EXPECT_THAT(stream_->received(), ElementsAre("first"));
}

TEST_F(PipeListenerTest, KeysOfEndedStreamsAreRejected) {
  const std::string forgotten = listener_->Expect(stream_);
  listener_->Forget(forgotten);
  const std::string expired = listener_->Expect(std::weak_ptr<Stream>());
  for (const std::string& key : {forgotten, expired}) {
    RawLearner learner(*listener_);
    EXPECT_FALSE(learner.SendKey(key));
  }
}

TEST_F(PipeListenerTest, OversizedMessagesAreRejectedByTheirLength) {
  RawLearner learner(*listener_);
  ASSERT_TRUE(learner.SendKey(listener_->Expect(stream_)));
  learner.Send(Framed(std::string(kMessageBytesMax + 1, 'x')).substr(0, 4));
  EXPECT_THAT(stream_->WaitForEnd(),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("a request of 10001 bytes, limit request_bytes_max is 10000")));
  EXPECT_EQ(learner.Receive(), "");
}

TEST_F(PipeListenerTest, EndedStreamClosesThePipes) {
  RawLearner learner(*listener_);
  ASSERT_TRUE(learner.SendKey(listener_->Expect(stream_)));
  for (int i = 0; i < 10; ++i) {
    learner.Send(Framed("?"));
  }
  EXPECT_EQ(learner.Receive(90).size(), 90);
  EXPECT_EQ(stream_->received().size(), 10);
}

TEST_F(PipeListenerTest, SilentConnectionBlocksOthersOnlyBriefly) {
  std::vector<std::unique_ptr<RawLearner>> silent;
  silent.reserve(kConnectionCount);
  for (int i = 0; i < kConnectionCount; ++i) {
    silent.push_back(std::make_unique<RawLearner>(*listener_));
  }
  // Connections beyond the limit are closed at once; the others stay open.
  EXPECT_TRUE(silent.back()->IsClosedByServer());
  silent.clear();
  const std::string key = listener_->Expect(stream_);
  bool is_in = false;
  while (!is_in) {
    RawLearner learner(*listener_);
    is_in = learner.SendKey(key);
    if (is_in) {
      learner.Send(Framed("now?"));
      learner.Receive(4);
    }
  }
  EXPECT_THAT(stream_->received(), ElementsAre("now?"));
}

TEST_F(PipeListenerTest, AllPipesEndWithIt) {
  RawLearner learner(*listener_);
  ASSERT_TRUE(learner.SendKey(listener_->Expect(stream_)));
  learner.Send(Framed("?"));
  EXPECT_EQ(learner.Receive(9).size(), 9);
  const RawLearner silent(*listener_);
  listener_ = nullptr;
  EXPECT_EQ(learner.Receive(), "");
  EXPECT_TRUE(silent.IsClosedByServer());
  EXPECT_THAT(stream_->WaitForEnd(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

TEST_F(PipeListenerTest, OtherUsersAreRejected) {
  if (geteuid() != 0) {
    GTEST_SKIP() << "only root can connect as another user";
  }
  const pid_t child = fork();
  if (child == 0) {
    if (setuid(65534) != 0) {
      _exit(1);
    }
    const RawLearner learner(*listener_);
    _exit(learner.connected() && learner.IsClosedByServer() ? 0 : 2);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "the connection was not closed before a key was sent";
}

}  // namespace
}  // namespace procgen
