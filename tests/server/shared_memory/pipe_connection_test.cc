#include "server/shared_memory/pipe_connection.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/shared_memory/file_descriptor.h"
#include "tests/server/shared_memory/learner_pipe_ends.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

constexpr size_t kMessageBytesMax = 10'000;

// A PipeConnection and the learner's ends.
class PipeConnectionTest : public testing::Test {
 protected:
  void SetUp() override {
    pipes_ = PipeConnection::Make(kMessageBytesMax);
    ASSERT_NE(pipes_, nullptr);
    std::array<int, 2> sockets = {};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
    const FileDescriptor ours(sockets[0]);
    const FileDescriptor theirs(sockets[1]);
    ASSERT_TRUE(pipes_->HandOver(ours.number()));
    other_ = LearnerPipeEnds::Receive(theirs.number());
    ASSERT_TRUE(other_.has_value());
  }

  void Send(const std::string& bytes) const {
    ASSERT_EQ(write(other_->requests.number(), bytes.data(), bytes.size()), ssize_t(bytes.size()));
  }
  // Reads until the pipe is closed.
  std::string ReceiveAll() const {
    std::string received;
    char byte = 0;
    while (read(other_->responses.number(), &byte, 1) == 1) {
      received.push_back(byte);
    }
    return received;
  }
  void CloseLearner() { other_.reset(); }
  // The next message; nullopt if there is none.
  std::optional<absl::string_view> Received() {
    const auto message = pipes_->Receive();
    EXPECT_THAT(message, IsOk());
    return message.value_or(std::nullopt);
  }
  static std::string Framed(const std::string& message) {
    const auto length = static_cast<uint32_t>(message.size());
    std::string bytes(sizeof(length), '\0');
    std::memcpy(bytes.data(), &length, sizeof(length));
    return bytes + message;
  }

  std::unique_ptr<PipeConnection> pipes_;
  std::optional<LearnerPipeEnds> other_;
};

TEST_F(PipeConnectionTest, ReceiveOnAnEmptyPipeDoesNotBlock) {
  EXPECT_EQ(Received(), std::nullopt);
  const std::string bytes = Framed("one") + Framed("two");
  for (size_t i = 0; i < Framed("one").size() - 1; ++i) {
    Send(bytes.substr(i, 1));
    EXPECT_EQ(Received(), std::nullopt) << i;
  }
  Send(bytes.substr(Framed("one").size() - 1));
  EXPECT_EQ(Received(), "one");
  EXPECT_EQ(Received(), "two");
  EXPECT_EQ(Received(), std::nullopt);
}

TEST_F(PipeConnectionTest, WatchReportsEarlierAndLaterMessages) {
  Send(Framed("before"));
  pipes_->Watch();
  EXPECT_TRUE(pipes_->AwaitInput());
  EXPECT_EQ(Received(), "before");
  pipes_->Watch();
  std::thread later([this] { Send(Framed("after")); });
  EXPECT_TRUE(pipes_->AwaitInput());
  later.join();
  EXPECT_EQ(Received(), "after");
}

TEST_F(PipeConnectionTest, PeerCloseIsReported) {
  Send(Framed("last").substr(0, 6));
  EXPECT_EQ(Received(), std::nullopt);
  pipes_->Watch();
  CloseLearner();
  EXPECT_TRUE(pipes_->AwaitInput());
  EXPECT_THAT(pipes_->Receive(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

TEST_F(PipeConnectionTest, WritingToAClosedPipeRaisesNoSignal) {
  CloseLearner();
  EXPECT_TRUE(pipes_->Send({"unread"}));
}

TEST_F(PipeConnectionTest, SendToALearnerThatDoesNotReadDoesNotBlock) {
  const std::string large(kMessageBytesMax, 'x');
  int sent = 0;
  while (pipes_->Send({large})) {
    ++sent;
  }
  EXPECT_GT(sent, 0);
}

TEST_F(PipeConnectionTest, CloseEndsAWait) {
  Send(Framed("unwatched"));
  bool is_open = true;
  std::thread waiting([&] { is_open = pipes_->AwaitInput(); });
  pipes_->HangUp();
  waiting.join();
  EXPECT_FALSE(is_open);
  EXPECT_FALSE(pipes_->AwaitInput());
  EXPECT_FALSE(pipes_->Send({"?"}));
  EXPECT_EQ(Received(), "unwatched");
  EXPECT_THAT(pipes_->Receive(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

TEST_F(PipeConnectionTest, MessagesBeforeCloseAreReceived) {
  EXPECT_TRUE(pipes_->Send({"la", "st"}));
  pipes_->HangUp();
  EXPECT_EQ(ReceiveAll(), Framed("last"));
}

TEST_F(PipeConnectionTest, VanishedLearnerIsNotAccepted) {
  std::array<int, 2> sockets = {};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
  const FileDescriptor ours(sockets[0]);
  close(sockets[1]);
  const auto pipes = PipeConnection::Make(kMessageBytesMax);
  EXPECT_FALSE(pipes->HandOver(ours.number()));
  EXPECT_THAT(pipes->Receive(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

}  // namespace
}  // namespace procgen
