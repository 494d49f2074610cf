// procgen-top, next to a server process whose pool is stepped.

#include <netinet/in.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
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
    // The first step loads the game's art, which takes longer than the others.
    procgen_client::Batch first;
    EXPECT_THAT(stream_->Step({4, 4, 4, 4}, &first), IsOk());
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
  ASSERT_EQ(busy.size(), 16) << lines[7];
  EXPECT_EQ(busy[0], "pools/busy");
  EXPECT_EQ(busy[2], "maze");
  EXPECT_EQ(busy[4], "4");
  EXPECT_EQ(busy[5], "yes");
  EXPECT_GT(std::stoll(busy[6]), 0);
  EXPECT_EQ(busy[9], "ms");
  EXPECT_GT(std::stoll(busy[10]), 0);
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

TEST(TopTest, PoolIsDeleted) {
  ServerProcess process({"--address=127.0.0.1:0"});
  const std::string address = process.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  ASSERT_THAT((*client)->CreatePool(MazeSpec(2), "stray"), IsOk());
  const Result deleted = RunTop("--delete=stray --server=" + address);
  EXPECT_EQ(deleted.exit_status, 0);
  EXPECT_EQ(deleted.output, "deleted pools/stray\n");
  EXPECT_TRUE((*client)->ListPools()->empty());
  const Result again = RunTop("--delete=pools/stray --server=" + address);
  EXPECT_EQ(again.exit_status, 1);
  EXPECT_THAT(again.output, HasSubstr("pools/stray"));
}

TEST(TopTest, InvalidFlagsAreReported) {
  const Result interval = RunTop("--interval=1ms");
  EXPECT_EQ(interval.exit_status, 2);
  EXPECT_THAT(interval.output, HasSubstr("--interval is 1ms, allowed: 100ms to 1h"));
  const Result argument = RunTop("127.0.0.1:1");
  EXPECT_EQ(argument.exit_status, 2);
  EXPECT_THAT(argument.output, HasSubstr("'127.0.0.1:1' is not a flag"));
}

TEST(TopTest, FlagsOfThisProgramAreListed) {
  const Result help = RunTop("--help");
  for (const char* flag : {"--server", "--interval", "--sort", "--color", "--once", "--delete"}) {
    EXPECT_THAT(help.output, HasSubstr(flag));
  }
  EXPECT_THAT(help.output, Not(HasSubstr("--flagfile")));
  EXPECT_THAT(RunTop("--sort=size").output,
              HasSubstr("--sort is 'size', allowed: steps, return, length, latency, age, name"));
  EXPECT_THAT(RunTop("--color=red").output,
              HasSubstr("--color is 'red', allowed: auto, always, never"));
}

// Expects that the program says within 2 seconds, and its start on a busy machine, that there is no
// server at an address.
void ExpectReportedSoon(const std::string& address) {
  const absl::Time begin = absl::Now();
  const Result result = RunTop("--server=" + address);
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_THAT(result.output, HasSubstr(address));
  EXPECT_LT(absl::Now() - begin, absl::Seconds(8));
}

TEST(TopTest, ServerThatIsNotThereIsReportedSoon) {
  ExpectReportedSoon("unix:/nonexistent/socket");
}

TEST(TopTest, PeerThatIsSilentIsReportedSoon) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  ASSERT_EQ(bind(listener, generic, size), 0);
  ASSERT_EQ(listen(listener, 8), 0);
  ASSERT_EQ(getsockname(listener, generic, &size), 0);
  ExpectReportedSoon(absl::StrCat("127.0.0.1:", ntohs(address.sin_port)));
  close(listener);
}

TEST(TopTest, ColorIsAChoice) {
  ServerProcess process({"--address=127.0.0.1:0"});
  const std::string flags = "--once --interval=100ms --server=" + process.Address();
  EXPECT_THAT(RunTop(flags + " --color=always").output, HasSubstr("\x1b[30;42mPOOL"));
  EXPECT_THAT(RunTop(flags + " --color=never").output, Not(HasSubstr("\x1b")));
}

// procgen-top on a terminal of its own.
class TopOnTerminal {
 public:
  // `environment`: "NAME=VALUE" or empty.
  TopOnTerminal(const std::string& address, uint16_t rows, const char* environment = "") {
    const winsize size = {rows, 200, 0, 0};
    const std::string server = "--server=" + address;
    process_ = forkpty(&terminal_, nullptr, nullptr, &size);
    if (process_ == 0) {
      setenv("LC_ALL", "C.UTF-8", 1);
      unsetenv("NO_COLOR");
      putenv(const_cast<char*>(environment));
      execl(PROCGEN_TOP_BINARY, PROCGEN_TOP_BINARY, server.c_str(), "--interval=100ms",
            static_cast<char*>(nullptr));
      _exit(127);
    }
  }
  ~TopOnTerminal() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
    close(terminal_);
  }
  TopOnTerminal(const TopOnTerminal&) = delete;
  TopOnTerminal& operator=(const TopOnTerminal&) = delete;

  // Reads the output until `text` appears; with an empty `text`, until the end.
  std::string Read(const std::string& text) const {
    std::string all;
    char buffer[4096];
    ssize_t count = 0;
    while ((text.empty() || !absl::StrContains(all, text)) &&
           (count = read(terminal_, buffer, sizeof buffer)) > 0) {
      all.append(buffer, static_cast<size_t>(count));
    }
    return all;
  }
  void Press(const std::string& keys) const {
    EXPECT_EQ(write(terminal_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  void Signal(int signal) const { kill(process_, signal); }
  // Waits for the end; returns the exit status.
  int ExitStatus() {
    int status = -1;
    waitpid(process_, &status, 0);
    process_ = -1;
    return status;
  }

 private:
  int terminal_ = -1;
  pid_t process_ = -1;
};

TEST(TopTest, TerminalIsRefreshedAndRestored) {
  ServerProcess process({"--address=127.0.0.1:0"});
  const std::string address = process.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  TopOnTerminal top(address, 24);
  const std::string first = top.Read("STEPS/S");
  EXPECT_THAT(first, testing::StartsWith("\x1b[?1049h"));
  EXPECT_THAT(first, HasSubstr("\x1b[30;42mPOOL"));
  EXPECT_THAT(first, Not(HasSubstr("pools/later")));
  ASSERT_THAT((*client)->CreatePool(MazeSpec(1), "later"), IsOk());
  EXPECT_THAT(top.Read("pools/later"), HasSubstr("\x1b[H"));
  top.Signal(SIGINT);
  EXPECT_THAT(top.Read(""), testing::EndsWith("\x1b[?1049l"));
  EXPECT_EQ(top.ExitStatus(), 0);
}

TEST(TopTest, KeysSortScrollAndQuit) {
  ServerProcess process({"--address=127.0.0.1:0"});
  const std::string address = process.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  for (const char* pool : {"a", "b", "c", "d", "e", "f"}) {
    ASSERT_THAT((*client)->CreatePool(MazeSpec(1), pool), IsOk());
  }
  // 7 lines above the pools and one below leave 4 pools.
  TopOnTerminal top(address, 12, "NO_COLOR=1");
  EXPECT_THAT(top.Read("1-4 of 6 by steps"), Not(HasSubstr("\x1b[30;42m")));
  top.Press("n");
  top.Read("1-4 of 6 by name ");
  top.Press("\x1b[B");
  EXPECT_THAT(top.Read("2-5 of 6 by name "), HasSubstr("pools/e"));
  top.Press("G");
  EXPECT_THAT(top.Read("3-6 of 6 by name "), HasSubstr("pools/f"));
  top.Press("ig");
  EXPECT_THAT(top.Read("1-4 of 6 by name, reversed "), HasSubstr("\x1b[7mPOOL"));
  top.Press("q");
  EXPECT_THAT(top.Read(""), testing::EndsWith("\x1b[?1049l"));
  EXPECT_EQ(top.ExitStatus(), 0);
}

TEST(TopTest, LastViewOfADeadServerStaysUntilItIsBack) {
  auto process = std::make_unique<ServerProcess>(std::vector<std::string>{"--address=127.0.0.1:0"});
  const std::string address = process->Address();
  ASSERT_THAT((*procgen_client::Client::Connect(address))->CreatePool(MazeSpec(1), "old"), IsOk());
  TopOnTerminal top(address, 24);
  top.Read("pools/old");
  process.reset();
  top.Read("   LOST at ");
  EXPECT_THAT(top.Read("q quit"), HasSubstr("\x1b[2mpools/old"));
  // The next view does not show the server either.
  EXPECT_THAT(top.Read("   LOST at "), Not(HasSubstr("\x1b[1;36mprocgen-server")));
  EXPECT_THAT(top.Read("q quit"), HasSubstr("\x1b[2mpools/old"));
  process = std::make_unique<ServerProcess>(std::vector<std::string>{"--address=" + address});
  EXPECT_EQ(process->Address(), address);
  top.Read("\x1b[1;36mprocgen-server");
  top.Read("0-0 of 0 by steps");
  top.Press("q");
  top.Read("");
  EXPECT_EQ(top.ExitStatus(), 0);
}

}  // namespace
}  // namespace procgen
