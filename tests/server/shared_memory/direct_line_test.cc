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
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

constexpr size_t kMessageBytesMax = 10'000;

// A line and the other end of its socket.
class DirectLineTest : public testing::Test {
 protected:
  void SetUp() override {
    std::array<int, 2> ends = {};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
    line_ = DirectLine::Take(ends[0], kMessageBytesMax);
    ASSERT_NE(line_, nullptr);
    other_ = ends[1];
  }
  void TearDown() override { Leave(); }

  void Say(const std::string& bytes) const {
    ASSERT_EQ(send(other_, bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
  }
  void Leave() {
    if (other_ >= 0) {
      close(other_);
    }
    other_ = -1;
  }
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
  int other_ = -1;
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
  EXPECT_THAT(line_->ReceiveBytes(100), StatusIs(absl::StatusCode::kCancelled, HasSubstr("ended")));
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
}

}  // namespace
}  // namespace procgen
