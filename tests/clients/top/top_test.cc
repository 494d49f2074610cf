// procgen-top, next to a server process whose pool is stepped.

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr char kToken[] = "alice-token-0123456789";

struct Result {
  int exit_status = -1;
  std::string output;  // standard output and error
};

// Runs procgen-top. `environment`: "NAME=VALUE " or empty.
Result RunTop(const std::string& flags, const std::string& environment = "") {
  Result result;
  const std::string command = environment + PROCGEN_TOP_BINARY + " " + flags + " 2>&1";
  FILE* output = popen(command.c_str(), "r");
  int letter = 0;
  while ((letter = fgetc(output)) != EOF) {
    result.output.push_back(static_cast<char>(letter));
  }
  const int status = pclose(output);
  result.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

// Steps a pool of 4 environments until it is stopped.
class Learner {
 public:
  Learner(procgen_client::Client* client, const std::string& pool_id) {
    const auto pool = client->CreatePool(MazeSpec(4), pool_id);
    EXPECT_THAT(pool, IsOk());
    auto stream = client->Attach(pool->name());
    EXPECT_THAT(stream, IsOk());
    stream_ = *std::move(stream);
    thread_ = std::thread([this] {
      procgen_client::Batch batch;
      while (!stops_ && stream_->Step({4, 4, 4, 4}, &batch).ok()) {
      }
    });
  }
  ~Learner() {
    stops_ = true;
    thread_.join();
  }
  Learner(const Learner&) = delete;
  Learner& operator=(const Learner&) = delete;

 private:
  std::unique_ptr<procgen_client::StepStream> stream_;
  std::atomic<bool> stops_ = false;
  std::thread thread_;
};

TEST(TopTest, OncePrintsOneScreen) {
  ServerProcess process({"--address=127.0.0.1:0", "--workers=1"});
  const std::string address = process.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const Learner learner(client->get(), "busy");
  ASSERT_THAT((*client)->CreatePool(MazeSpec(2), "idle"), IsOk());
  const Result result = RunTop("--once --interval=1s --server=" + address);
  EXPECT_EQ(result.exit_status, 0);
  const std::vector<std::string> lines = absl::StrSplit(result.output, '\n');
  ASSERT_EQ(lines.size(), 10) << result.output;
  EXPECT_THAT(lines[0], HasSubstr(" at " + address));
  EXPECT_THAT(lines[1], HasSubstr("pools 2   environments 6   streams 1   workers 1 "));
  EXPECT_THAT(lines[2], Not(HasSubstr("steps/s 0 ")));
  EXPECT_THAT(lines[4], HasSubstr("p99 <= "));
  const std::vector<std::string> busy = absl::StrSplit(lines[7], ' ', absl::SkipEmpty());
  ASSERT_EQ(busy.size(), 10) << lines[7];
  EXPECT_EQ(busy[0], "pools/busy");
  EXPECT_EQ(busy[2], "maze");
  EXPECT_EQ(busy[3], "4");
  EXPECT_EQ(busy[4], "yes");
  EXPECT_GT(std::stoll(busy[5]), 0);
  EXPECT_GT(std::stoll(busy[6]), 0);
  EXPECT_THAT(lines[8], HasSubstr("pools/idle"));
  EXPECT_THAT(result.output, Not(HasSubstr("\x1b")));
}

TEST(TopTest, CredentialsAreThoseOfTheClient) {
  const std::string tokens = testing::TempDir() + "/procgen-top-test-tokens";
  std::ofstream(tokens) << "alice " << kToken << "\n";
  ServerProcess process({"--address=127.0.0.1:0", "--tokens=" + tokens});
  const std::string address = process.Address();
  procgen_client::ConnectOptions options;
  options.credentials.emplace().token = kToken;
  const auto client = procgen_client::Client::Connect(address, options);
  ASSERT_THAT(client, IsOk());
  ASSERT_THAT((*client)->CreatePool(MazeSpec(2), "hers"), IsOk());
  const std::string flags = "--once --interval=100ms --server=" + address;
  const Result let_in = RunTop(flags, std::string("PROCGEN_SERVER_TOKEN=") + kToken + " ");
  EXPECT_EQ(let_in.exit_status, 0);
  EXPECT_THAT(let_in.output, HasSubstr("pools/hers  alice"));
  const Result rejected = RunTop(flags);
  EXPECT_EQ(rejected.exit_status, 1);
  EXPECT_THAT(rejected.output, HasSubstr("procgen-top: the call has no token"));
}

TEST(TopTest, InvalidFlagsAreReported) {
  const Result interval = RunTop("--interval=1ms");
  EXPECT_EQ(interval.exit_status, 2);
  EXPECT_THAT(interval.output, HasSubstr("--interval is 1ms, allowed: 100ms to 1h"));
  const Result argument = RunTop("127.0.0.1:1");
  EXPECT_EQ(argument.exit_status, 2);
  EXPECT_THAT(argument.output, HasSubstr("'127.0.0.1:1' is not a flag"));
}

// Reads the terminal's output until `text` appears; with an empty `text`, until the end.
std::string ReadTerminal(int terminal, const std::string& text) {
  std::string all;
  char buffer[4096];
  ssize_t count = 0;
  while ((text.empty() || !absl::StrContains(all, text)) &&
         (count = read(terminal, buffer, sizeof buffer)) > 0) {
    all.append(buffer, static_cast<size_t>(count));
  }
  return all;
}

TEST(TopTest, TerminalIsRefreshedAndRestored) {
  ServerProcess process({"--address=127.0.0.1:0"});
  const std::string server = "--server=" + process.Address();
  const auto client = procgen_client::Client::Connect(server.substr(server.find('=') + 1));
  ASSERT_THAT(client, IsOk());
  int terminal = -1;
  const pid_t top = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (top == 0) {
    execl(PROCGEN_TOP_BINARY, PROCGEN_TOP_BINARY, server.c_str(), "--interval=100ms",
          static_cast<char*>(nullptr));
    _exit(127);
  }
  const std::string first = ReadTerminal(terminal, "STEPS/S");
  EXPECT_THAT(first, testing::StartsWith("\x1b[?1049h"));
  EXPECT_THAT(first, Not(HasSubstr("pools/later")));
  ASSERT_THAT((*client)->CreatePool(MazeSpec(1), "later"), IsOk());
  EXPECT_THAT(ReadTerminal(terminal, "pools/later"), HasSubstr("\x1b[H"));
  kill(top, SIGINT);
  EXPECT_THAT(ReadTerminal(terminal, ""), testing::EndsWith("\x1b[?1049l"));
  int status = -1;
  waitpid(top, &status, 0);
  EXPECT_EQ(status, 0);
  close(terminal);
}

}  // namespace
}  // namespace procgen
