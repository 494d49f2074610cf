#include "server/net/listener.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

// Connects to an abstract unix socket; returns -1 on failure.
int ConnectTo(absl::string_view name) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  const int connection = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  return connect(connection, reinterpret_cast<const sockaddr*>(&address), size) == 0 ? connection
                                                                                     : -1;
}

// The result of a client's first read. 1: a byte; 0: end of stream.
int FirstReadOf(absl::string_view name) {
  char byte = 0;
  return static_cast<int>(read(ConnectTo(name), &byte, 1));
}

TEST(ListenerTest, StopsDespiteConstantConnections) {
  auto listener = Listener::ListenInternal();
  ASSERT_THAT(listener, IsOk());
  const std::string target = (*listener)->internal_target();
  const absl::string_view name = absl::StripPrefix(target, "unix-abstract:");
  std::atomic<int> taken_count = 0;
  (*listener)->Start([&](int /*listening*/, int connection) {
    close(connection);
    close(ConnectTo(name));  // the next connection
    ++taken_count;
  });
  close(ConnectTo(name));
  while (taken_count < 100) {
  }
  *listener = nullptr;
}

TEST(ListenerTest, SocketPathOfALaterServerIsKept) {
  const TemporaryFolder folder;
  Address address;
  address.unix_path = folder.At("socket");
  auto first = Listener::Listen(address);
  ASSERT_THAT(first, IsOk());
  std::filesystem::remove(address.unix_path);
  auto second = Listener::Listen(address);
  ASSERT_THAT(second, IsOk());
  *first = nullptr;
  EXPECT_TRUE(std::filesystem::exists(address.unix_path));
  *second = nullptr;
  EXPECT_FALSE(std::filesystem::exists(address.unix_path));
}

TEST(ListenerTest, OtherProcessesAreRejected) {
  const auto listener = Listener::ListenInternal();
  ASSERT_THAT(listener, IsOk());
  std::atomic<int> taken_count = 0;
  (*listener)->Start([&](int /*listening*/, int connection) {
    ++taken_count;
    EXPECT_EQ(write(connection, "x", 1), 1);
    close(connection);
  });
  const std::string target = (*listener)->internal_target();
  const absl::string_view name = absl::StripPrefix(target, "unix-abstract:");
  EXPECT_EQ(FirstReadOf(name), 1);
  const pid_t other = fork();
  if (other == 0) {
    _exit(FirstReadOf(name) == 0 ? 7 : 1);
  }
  int end = 0;
  ASSERT_EQ(waitpid(other, &end, 0), other);
  EXPECT_TRUE(WIFEXITED(end) && WEXITSTATUS(end) == 7) << end;
  EXPECT_EQ(taken_count, 1);
}

}  // namespace
}  // namespace procgen
