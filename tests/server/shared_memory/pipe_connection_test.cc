#include "server/shared_memory/direct_line.h"

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
#include "tests/server/shared_memory/learners_ends.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

constexpr size_t kMessageBytesMax = 10'000;

// A line and the learner's ends of it.
class DirectLineTest : public testing::Test {
 protected:
  void SetUp() override {
    line_ = DirectLine::Make(kMessageBytesMax);
    ASSERT_NE(line_, nullptr);
    std::array<int, 2> sockets = {};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
    const FileDescriptor ours(sockets[0]);
    const FileDescriptor theirs(sockets[1]);
    ASSERT_TRUE(line_->HandOver(ours.number()));
    other_ = LearnersEnds::Receive(theirs.number());
    ASSERT_TRUE(other_.has_value());
  }

  void Say(const std::string& bytes) const {
    ASSERT_EQ(write(other_->requests.number(), bytes.data(), bytes.size()), ssize_t(bytes.size()));
  }
  // All that comes until the line ends.
  std::string Heard() const {
    std::string heard;
    char byte = 0;
    while (read(other_->responses.number(), &byte, 1) == 1) {
      heard.push_back(byte);
    }
    return heard;
  }
  void Leave() { other_.reset(); }
  // The next message; none: it is not there.
  std::optional<absl::string_view> Received() {
    const auto message = line_->Receive();
    EXPECT_THAT(message, IsOk());
    return message.value_or(std::nullopt);
  }
  static std::string Framed(const std::string& message) {
    const auto length = static_cast<uint32_t>(message.size());
    std::string bytes(sizeof(length), '\0');
    std::memcpy(bytes.data(), &length, sizeof(length));
    return bytes + message;
  }

  std::unique_ptr<DirectLine> line_;
  std::optional<LearnersEnds> other_;
};

TEST_F(DirectLineTest, NobodyWaitsForWhatIsNotThere) {
  EXPECT_EQ(Received(), std::nullopt);
  const std::string bytes = Framed("one") + Framed("two");
  for (size_t i = 0; i < Framed("one").size() - 1; ++i) {
    Say(bytes.substr(i, 1));
    EXPECT_EQ(Received(), std::nullopt) << i;
  }
  Say(bytes.substr(Framed("one").size() - 1));
  EXPECT_EQ(Received(), "one");
  EXPECT_EQ(Received(), "two");
  EXPECT_EQ(Received(), std::nullopt);
}

TEST_F(DirectLineTest, WhatIsWatchedIsToldWheneverItCame) {
  Say(Framed("before"));
  line_->Watch();
  EXPECT_TRUE(line_->AwaitInput());
  EXPECT_EQ(Received(), "before");
  line_->Watch();
  std::thread later([this] { Say(Framed("after")); });
  EXPECT_TRUE(line_->AwaitInput());
  later.join();
  EXPECT_EQ(Received(), "after");
}

TEST_F(DirectLineTest, TheOthersEndIsTold) {
  Say(Framed("last").substr(0, 6));
  EXPECT_EQ(Received(), std::nullopt);
  line_->Watch();
  Leave();
  EXPECT_TRUE(line_->AwaitInput());
  EXPECT_THAT(line_->Receive(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

TEST_F(DirectLineTest, NoSignalEndsWhoAnswersALearnerThatIsGone) {
  Leave();
  EXPECT_TRUE(line_->Send({"nobody reads this"}));
}

TEST_F(DirectLineTest, NobodyWaitsForALearnerThatReadsNothing) {
  const std::string large(kMessageBytesMax, 'x');
  int sent = 0;
  while (line_->Send({large})) {
    ++sent;
  }
  EXPECT_GT(sent, 0);
}

TEST_F(DirectLineTest, WhoHangsUpWaitsNoMore) {
  Say(Framed("unwatched"));
  bool is_open = true;
  std::thread waiting([&] { is_open = line_->AwaitInput(); });
  line_->HangUp();
  waiting.join();
  EXPECT_FALSE(is_open);
  EXPECT_FALSE(line_->AwaitInput());
  EXPECT_FALSE(line_->Send({"?"}));
  EXPECT_EQ(Received(), "unwatched");
  EXPECT_THAT(line_->Receive(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

TEST_F(DirectLineTest, WhatWasSentBeforeHangingUpIsStillReceived) {
  EXPECT_TRUE(line_->Send({"la", "st"}));
  line_->HangUp();
  EXPECT_EQ(Heard(), Framed("last"));
}

TEST_F(DirectLineTest, ALearnerThatIsGoneIsNotHandedOver) {
  std::array<int, 2> sockets = {};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
  const FileDescriptor ours(sockets[0]);
  close(sockets[1]);
  const auto line = DirectLine::Make(kMessageBytesMax);
  EXPECT_FALSE(line->HandOver(ours.number()));
  EXPECT_THAT(line->Receive(), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
}

}  // namespace
}  // namespace procgen
