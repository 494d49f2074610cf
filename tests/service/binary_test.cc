// The program procgen-server: its flags, its start and its end.

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/strip.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/envcore/pool/painted_art.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

// The program, run with `flags`; standard output and error are read together.
class ServerProcess {
 public:
  explicit ServerProcess(const std::vector<std::string>& flags) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    std::vector<char*> arguments = {const_cast<char*>(PROCGEN_SERVER_BINARY)};
    for (const std::string& flag : flags) {
      arguments.push_back(const_cast<char*>(flag.c_str()));
    }
    arguments.push_back(nullptr);
    process_ = fork();
    if (process_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      close(ends[1]);
      execv(arguments[0], arguments.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }

  ~ServerProcess() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
    fclose(output_);
  }

  // The address that it prints when clients can connect.
  std::string Address() {
    std::string line;
    while (ReadLine(&line)) {
      if (absl::StartsWith(line, "listening on ")) {
        return std::string(absl::StripPrefix(line, "listening on "));
      }
    }
    return "";
  }

  void Signal(int signal) const { kill(process_, signal); }

  // Waits for its end; returns the exit status, or -1 if a signal ended it.
  int Wait() {
    std::string line;
    while (ReadLine(&line)) {
      rest_ += line + "\n";
    }
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  // What it printed after the address.
  const std::string& rest() const { return rest_; }

 private:
  bool ReadLine(std::string* line) {
    line->clear();
    int letter = 0;
    while ((letter = fgetc(output_)) != EOF && letter != '\n') {
      line->push_back(static_cast<char>(letter));
    }
    return letter != EOF;
  }

  pid_t process_ = -1;
  FILE* output_ = nullptr;
  std::string rest_;
};

class SignalTest : public testing::TestWithParam<int> {};

TEST_P(SignalTest, DrainsAndExitsWithZero) {
  ServerProcess process({"--address=127.0.0.1:0", "--workers=2", "--drain_deadline=30s"});
  const std::string address = process.Address();
  ASSERT_NE(address, "");
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const auto pool = (*client)->CreatePool(MazeSpec(4));
  ASSERT_THAT(pool, IsOk());
  const auto stream = (*client)->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({4, 4, 4, 4}, &batch), IsOk());
  process.Signal(GetParam());
  absl::Status status;
  while (status.ok()) {
    status = (*stream)->Step({4, 4, 4, 4}, &batch);
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_EQ(process.Wait(), 0);
  EXPECT_THAT(process.rest(), HasSubstr("event=draining"));
  EXPECT_THAT(process.rest(), HasSubstr("event=stopped"));
}

INSTANTIATE_TEST_SUITE_P(Signals, SignalTest, testing::Values(SIGTERM, SIGINT));

// What a maze looks like on the server at `address`, whose catalog must tell of `art`.
std::string FirstPictureOf(const std::string& address, const std::string& art) {
  const auto client = procgen_client::Client::Connect(address);
  EXPECT_THAT(client, IsOk());
  const auto catalog = (*client)->GetCatalog();
  EXPECT_THAT(catalog, IsOk());
  EXPECT_EQ(catalog->art(), art);
  const auto pool = (*client)->CreatePool(MazeSpec(1));
  EXPECT_THAT(pool, IsOk());
  const auto stream = (*client)->Attach(pool->name());
  EXPECT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Observe(&batch), IsOk());
  return {batch.observations().begin(), batch.observations().end()};
}

TEST(BinaryTest, HelpListsTheFlags) {
  ServerProcess process({"--help"});
  process.Wait();
  for (const char* flag :
       {"--address", "--workers", "--pool_count_max", "--request_bytes_max",
        "--requests_in_flight_max", "--drain_deadline", "--art", "--log_level"}) {
    EXPECT_THAT(process.rest(), HasSubstr(flag));
  }
}

TEST(BinaryTest, WrongFlagsAreExplained) {
  ServerProcess process({"--workers=-3"});
  EXPECT_EQ(process.Wait(), 2);
  EXPECT_THAT(process.rest(), HasSubstr("--workers is -3, allowed: 1 to 1024"));
}

TEST(BinaryTest, ArtOfAFolderIsDrawnAndTold) {
  const std::string folder = testing::TempDir() + "/procgen-binary-test-art";
  PaintArtFolder(folder);
  ServerProcess plain({"--address=127.0.0.1:0"});
  ServerProcess painted({"--address=127.0.0.1:0", "--art=" + folder});
  const std::string painted_address = painted.Address();
  std::filesystem::remove_all(folder);
  const std::string own = FirstPictureOf(plain.Address(), "built-in");
  const std::string other = FirstPictureOf(painted_address, "folder");
  EXPECT_EQ(own.size(), other.size());
  EXPECT_NE(own, other);
}

TEST(BinaryTest, FolderWithoutArtIsExplained) {
  const std::string folder = testing::TempDir() + "/procgen-binary-test-no-art";
  ServerProcess process({"--address=127.0.0.1:0", "--art=" + folder});
  EXPECT_EQ(process.Wait(), 2);
  EXPECT_THAT(process.rest(),
              HasSubstr("--art: art folder '" + folder + "': there is no such folder"));
}

TEST(BinaryTest, AddressInUseIsAnError) {
  ServerProcess first({"--address=127.0.0.1:0"});
  const std::string address = first.Address();
  ServerProcess second({"--address=" + address});
  EXPECT_EQ(second.Wait(), 1);
  EXPECT_THAT(second.rest(), HasSubstr("cannot listen on " + address));
}

TEST(BinaryTest, UnixSocketIsServed) {
  const std::string address = "unix:" + testing::TempDir() + "/procgen-binary-test.sock";
  ServerProcess process({"--address=" + address});
  ASSERT_EQ(process.Address(), address);
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  EXPECT_THAT((*client)->GetCatalog(), IsOk());
}

}  // namespace
}  // namespace procgen
