// The examples of clients/cpp/README.md compile and run, word for word.

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/servers.h"
#include "tests/clients/cpp/server_fixture.h"

namespace procgen {
namespace {

std::string ReadFile(const std::string& path) {
  const std::ifstream file(absl::StrCat(PROCGEN_SOURCE_DIR, "/", path));
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// The text between two markers.
std::string Between(const std::string& text, const std::string& begin, const std::string& end) {
  const size_t from = text.find(begin) + begin.size();
  return text.substr(from, text.find(end, from) - from);
}

// Text without indentation and line breaks.
std::string Words(const std::string& text) {
  std::string words;
  std::stringstream stream(text);
  for (std::string word; stream >> word;) {
    words += word + " ";
  }
  return words;
}

class ReadmeTest : public ServerTest {};

TEST_F(ReadmeTest, ExampleRuns) {
  int learned = 0;
  // NOLINTNEXTLINE(readability-identifier-naming): the name in the example
  const auto Learn = [&](absl::Span<const uint8_t> observations, absl::Span<const float> rewards,
                         absl::Span<const uint8_t> first) {
    EXPECT_EQ(observations.size(), 64U * 64 * 64 * 3);
    EXPECT_EQ(rewards.size(), 64U);
    EXPECT_EQ(first.size(), 64U);
    ++learned;
  };
#define SERVER_ADDRESS server_->address()
  // EXAMPLE
  auto servers = procgen_client::Servers::Connect(SERVER_ADDRESS).value();
  procgen::PoolOptions options;
  options.games = {"coinrun"};
  options.env_count = 64;
  auto pool = procgen_client::CreatePool(servers, options).value();
  std::vector<uint8_t> observations(64 * 64 * 64 * 3);
  std::vector<float> rewards(64);
  std::vector<uint8_t> first(64);
  procgen::Batch batch;
  batch.observations = absl::MakeSpan(observations);
  batch.rewards = absl::MakeSpan(rewards);
  batch.first = absl::MakeSpan(first);
  const std::vector<int32_t> actions(64, 7);
  for (int i = 0; i < 100 && pool->Step({.count = 64, .actions = actions}, {}, batch).ok(); ++i) {
    Learn(observations, rewards, first);
  }
  // END
#undef SERVER_ADDRESS
  EXPECT_EQ(learned, 100);
}

TEST_F(ReadmeTest, StatesExampleRuns) {
#define SERVER_ADDRESS server_->address()
  // STATES EXAMPLE
  auto servers = procgen_client::Servers::Connect(SERVER_ADDRESS).value();
  procgen::PoolOptions options;
  options.games = {"maze"};
  options.env_count = 4;
  auto pool = procgen_client::CreatePool(servers, options).value();
  const std::vector<std::string> states = pool->SaveStates({0, 1, 2, 3}).value();
  const std::vector<int32_t> actions(4, 7);
  pool->Step({.count = 4, .actions = actions}, {}, {}).IgnoreError();
  procgen::Status restored = pool->RestoreStates({{.environment = 0, .snapshot = states[0]}});
  // STATES END
#undef SERVER_ADDRESS
  EXPECT_THAT(restored, IsOk());
  EXPECT_EQ(pool->SaveStates({0, 1, 2, 3}).value()[0], states[0]);
}

TEST_F(ReadmeTest, ExamplesEqualTheReadme) {
  const std::string readme = ReadFile("clients/cpp/README.md");
  const std::string tested = ReadFile("tests/clients/cpp/readme_test.cc");
  const size_t second = readme.find("```cpp\n", readme.find("```cpp\n") + 1);
  for (const auto& [shown, run] :
       {std::pair{Between(readme, "```cpp\n", "```"),
                  Between(tested, "  // EXAMPLE\n", "// END\n")},
        std::pair{Between(readme.substr(second), "```cpp\n", "```"),
                  Between(tested, "  // STATES EXAMPLE\n", "// STATES END\n")}}) {
    EXPECT_EQ(Words(absl::StrReplaceAll(run, {{"SERVER_ADDRESS", "\"127.0.0.1:50051\""}})),
              Words(shown));
  }
}

}  // namespace
}  // namespace procgen
