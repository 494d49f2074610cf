#include "server/rpc/auth/token_file.h"

#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "server/logging/event_log.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr char kAlice[] = "alice-0123456789abcdef";
constexpr char kBob[] = "bob+0123456789abcdef==";

TEST(ParseTokensTest, OwnersAndTokensAreParsedAndCommentsSkipped) {
  const auto digests = ParseTokens(std::string("# who\n\n  alice\t") + kAlice +
                                   "  # her first\r\nbob " + kBob + "\nalice " + kBob + "2");
  ASSERT_THAT(digests, IsOk());
  ASSERT_EQ(digests->size(), 3U);
  EXPECT_EQ((*digests)[0].owner, "alice");
  EXPECT_EQ((*digests)[1].owner, "bob");
  EXPECT_EQ((*digests)[2].owner, "alice");
}

TEST(ParseTokensTest, InvalidLinesAreNumberedAndNeverEchoed) {
  for (const auto& [line, reason] :
       {std::pair<std::string, std::string>{"secretsecretsecret", "line 2 has 1 words"},
        {"alice secret-secret-secret x", "line 2 has 3 words"},
        {"alice secret", "line 2 has a token of 6 characters, allowed: 16 to 512"},
        {"alice secret-secret-s\xc3\xa9", "line 2 has a token of 17 characters"},
        {"alice secret" + std::string(512, 's'), "line 2 has a token of 518 characters"},
        {std::string(129, 'a') + " secret-secret-secret", "line 2 has an owner of 129 characters"},
        {"a\x01 secret-secret-secret", "line 2 has an owner of 2 characters"}}) {
    const auto digests = ParseTokens(std::string("bob ") + kBob + "\n" + line);
    EXPECT_THAT(digests, StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(reason)));
    EXPECT_THAT(std::string(digests.status().message()), Not(HasSubstr("secret")));
  }
}

TEST(ParseTokensTest, DuplicateTokenIsRejected) {
  EXPECT_THAT(ParseTokens(std::string("alice ") + kBob + "\nbob " + kBob),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "line 2 has the token of line 1, allowed: each once"));
}

TEST(ParseTokensTest, FileWithoutTokensIsRejected) {
  EXPECT_THAT(ParseTokens("# nobody\n"),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("has no token")));
}

class TokenFileTest : public testing::Test {
 protected:
  void SetUp() override { Write(path_, std::string("alice ") + kAlice + "\n"); }

  static void Write(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  void Replace(const std::string& text) {
    Write(path_ + ".next", text);
    std::filesystem::rename(path_ + ".next", path_);
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.At("tokens");
};

TEST_F(TokenFileTest, TokensIdentifyTheirOwner) {
  const auto tokens = TokenFile::Open(path_);
  ASSERT_THAT(tokens, IsOk());
  EXPECT_EQ((*tokens)->OwnerOf(kAlice), "alice");
  for (const std::string& wrong : {std::string(), std::string(kBob), kAlice + std::string("0"),
                                   std::string(kAlice).substr(1), std::string("alice")}) {
    EXPECT_EQ((*tokens)->OwnerOf(wrong), std::nullopt) << wrong;
  }
}

TEST_F(TokenFileTest, LookupAfterAReplacementUsesTheNewFile) {
  const auto tokens = TokenFile::Open(path_);
  ASSERT_THAT(tokens, IsOk());
  std::atomic<bool> is_replaced = false;
  std::atomic<bool> stops = false;
  std::vector<std::thread> callers(4);
  for (std::thread& caller : callers) {
    caller = std::thread([&] {
      while (!stops) {
        const bool is_new = is_replaced;
        const bool alice_is_there = (*tokens)->OwnerOf(kAlice).has_value();
        EXPECT_FALSE(is_new && alice_is_there);
      }
    });
  }
  Replace(std::string("bob ") + kBob);
  is_replaced = true;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ((*tokens)->OwnerOf(kBob), "bob");
  }
  stops = true;
  for (std::thread& caller : callers) {
    caller.join();
  }
}

TEST_F(TokenFileTest, BrokenOrMissingFileKeepsThePreviousTokens) {
  const auto tokens = TokenFile::Open(path_);
  ASSERT_THAT(tokens, IsOk());
  for (const char* broken : {"", "alice", "alice short"}) {
    Replace(broken);
    EXPECT_EQ((*tokens)->OwnerOf(kAlice), "alice");
  }
  std::filesystem::remove(path_);
  EXPECT_EQ((*tokens)->OwnerOf(kAlice), "alice");
  Write(path_, std::string("bob ") + kBob);
  EXPECT_EQ((*tokens)->OwnerOf(kBob), "bob");
}

TEST_F(TokenFileTest, BrokenOrWorldReadableFileIsLoggedOnce) {
  const auto tokens = TokenFile::Open(path_);
  ASSERT_THAT(tokens, IsOk());
  testing::internal::CaptureStderr();
  Replace("alice");
  (*tokens)->OwnerOf(kAlice);
  (*tokens)->OwnerOf(kAlice);
  Replace(std::string("bob ") + kBob);
  chmod(path_.c_str(), 0644);
  (*tokens)->OwnerOf(kBob);
  FlushLog(absl::Seconds(10));
  const std::string log = testing::internal::GetCapturedStderr();
  const size_t first = log.find("event=tokens_reload_failed");
  EXPECT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find("event=tokens_reload_failed", first + 1), std::string::npos) << log;
  EXPECT_THAT(log, HasSubstr("event=token_file_world_readable"));
  EXPECT_THAT(log, Not(HasSubstr(kBob)));
}

TEST_F(TokenFileTest, NonFileIsRejectedByName) {
  EXPECT_THAT(TokenFile::Open(path_ + "-none"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(path_ + "-none")));
  EXPECT_THAT(TokenFile::Open(testing::TempDir()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("is not a regular file")));
  Replace(std::string((1 << 20) + 1, '#'));
  EXPECT_THAT(TokenFile::Open(path_), StatusIs(absl::StatusCode::kInvalidArgument,
                                               HasSubstr("has more than 1048576 bytes")));
}

}  // namespace
}  // namespace procgen
