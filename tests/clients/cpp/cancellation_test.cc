// Cancelled waits: for a connection, for calls, and for streams over both transports.
#include "procgen_client/cancellation.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

// A wait ends within twice the check interval; the rest is for a busy machine.
constexpr absl::Duration kEndedWithin = absl::Seconds(5);

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

class CancelledWaitTest : public ServiceTest {
 protected:
  // A client whose waits end once is_cancelled_ is true.
  std::unique_ptr<procgen_client::Client> Cancellable() {
    procgen_client::ConnectOptions options;
    options.is_cancelled = [this] { return is_cancelled_.load(); };
    return *procgen_client::Client::Connect(server_->address(), options);
  }

  // Cancels Receive while a long request runs.
  void CancelReceive(procgen_client::Client* client, const v1::PoolSpec& spec) {
    const std::string name = CreatePool(spec);
    const auto stream = client->Attach(name);
    ASSERT_THAT(stream, IsOk());
    v1::StepPoolRequest request = StepRequest(std::vector<int32_t>(spec.env_count(), 4));
    request.mutable_step()->set_repeat_count(1000);
    request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
    ASSERT_THAT((*stream)->Send(std::move(request)), IsOk());
    is_cancelled_ = true;
    procgen_client::Batch batch;
    const absl::Time begin = absl::Now();
    EXPECT_THAT((*stream)->Receive(&batch), StatusIs(absl::StatusCode::kCancelled, testing::_));
    EXPECT_LT(absl::Now() - begin, kEndedWithin);
    EXPECT_THAT((*stream)->Receive(&batch), StatusIs(absl::StatusCode::kCancelled, testing::_));
  }

  std::atomic<bool> is_cancelled_ = false;
};

TEST_F(CancelledWaitTest, ReceiveReturnsCancelled) {
  const auto client = Cancellable();
  v1::PoolSpec spec = MazeSpec(256);
  spec.set_games(0, "caveflyer");
  CancelReceive(client.get(), spec);
}

TEST_F(CancelledWaitTest, ReceiveOfAnAbortedStreamReturnsCancelled) {
  v1::PoolSpec spec = MazeSpec(256);
  spec.set_games(0, "caveflyer");
  const auto stream = CreateAndAttach(spec);
  v1::StepPoolRequest request = StepRequest(std::vector<int32_t>(256, 4));
  request.mutable_step()->set_repeat_count(1000);
  ASSERT_THAT(stream->Send(std::move(request)), IsOk());
  stream->Abort();
  procgen_client::Batch batch;
  EXPECT_THAT(stream->Receive(&batch), StatusIs(absl::StatusCode::kCancelled, testing::_));
}

TEST_F(CancelledWaitTest, ConnectReturnsCancelled) {
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
