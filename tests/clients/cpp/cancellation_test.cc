#include "procgen_client/cancellation.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(CancellationTest, StaysCancelled) {
  int calls = 0;
  procgen_client::Cancellation cancellation([&calls] { return ++calls == 2; });
  EXPECT_FALSE(cancellation.Check());
  EXPECT_TRUE(cancellation.Check());
  EXPECT_TRUE(cancellation.Check());
  EXPECT_EQ(calls, 2);
  EXPECT_FALSE(cancellation.Sleep(absl::Hours(1)));
}

TEST(CancellationTest, NeverCancelsWithoutACheck) {
  procgen_client::Cancellation cancellation(nullptr);
  EXPECT_FALSE(cancellation.Check());
  EXPECT_TRUE(cancellation.Sleep(absl::Milliseconds(1)));
}

TEST(CancellationTest, ConnectReturnsCancelled) {
  // Listens without accepting connections.
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  procgen_client::ConnectOptions options;
  options.timeout = absl::Hours(1);
  int checks = 0;
  options.is_cancelled = [&checks] { return ++checks == 2; };
  EXPECT_THAT(
      procgen_client::Client::Connect(absl::StrCat("127.0.0.1:", ntohs(address.sin_port)), options),
      StatusIs(absl::StatusCode::kCancelled, testing::_));
  close(listener);
}

}  // namespace
}  // namespace procgen
