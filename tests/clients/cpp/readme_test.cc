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
#include "procgen_client/client.h"
#include "tests/service/service_fixture.h"

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

class ReadmeTest : public ServiceTest {};

TEST_F(ReadmeTest, ExampleRuns) {
  int learned = 0;
  // NOLINTNEXTLINE(readability-identifier-naming): the name in the example
  const auto Learn = [&](absl::Span<const uint8_t> observations, absl::Span<const float> rewards,
                         absl::Span<const bool> first) {
    EXPECT_EQ(observations.size(), 64U * 64 * 64 * 3);
    EXPECT_EQ(rewards.size(), 64U);
    EXPECT_EQ(first.size(), 64U);
    ++learned;
  };
#define SERVER_ADDRESS server_->address()
  // EXAMPLE
  auto client = procgen_client::Client::Connect(SERVER_ADDRESS).value();
  procgen::v1::PoolSpec spec;
  spec.add_games("coinrun");
  spec.set_env_count(64);
  auto stream = client->Attach(client->CreatePool(spec)->name()).value();
  procgen_client::Batch batch;
  for (int i = 0; i < 100 && stream->Step(std::vector<int32_t>(64, 7), &batch).ok(); ++i) {
    Learn(batch.observations(), batch.rewards(), batch.first());
  }
  // END
#undef SERVER_ADDRESS
  EXPECT_EQ(learned, 100);
}

TEST_F(ReadmeTest, StatesExampleRuns) {
#define SERVER_ADDRESS server_->address()
  // STATES EXAMPLE
  auto client = procgen_client::Client::Connect(SERVER_ADDRESS).value();
  procgen::v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(4);
  const std::string pool = client->CreatePool(spec)->name();
  auto stream = client->Attach(pool).value();
  procgen_client::Batch batch;
  const std::vector<procgen::v1::State> states = client->SaveStates(pool).value();
  stream->Step(std::vector<int32_t>(4, 7), &batch).IgnoreError();
  absl::Status restored = client->RestoreStates(pool, states);
  if (restored.ok()) {
    restored = stream->Observe(&batch);
  }
  // STATES END
#undef SERVER_ADDRESS
  EXPECT_THAT(restored, IsOk());
  EXPECT_THAT(batch.episode_lengths(), testing::Each(0));
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
