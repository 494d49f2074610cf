// Attacks by clients without credentials, and excessive use by clients with credentials.

#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/raw_call.h"
#include "tests/service/security/access_fixture.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class UntrustedClientTest : public AccessTest {
 protected:
  // Whether the server closed the connection. Waits for its first byte or the close.
  static bool IsClosed(int connection) {
    char byte = 0;
    return recv(connection, &byte, 1, 0) <= 0;
  }

  // Peak memory of a process in KiB; -1 if it is not available.
  static int64_t PeakKilobytes(int process_id) {
    std::ifstream facts(absl::StrCat("/proc/", process_id, "/status"));
    int64_t peak_kb = -1;
    for (std::string line; std::getline(facts, line);) {
      absl::string_view rest = line;
      if (absl::ConsumePrefix(&rest, "VmHWM:") && absl::ConsumeSuffix(&rest, " kB")) {
        EXPECT_TRUE(absl::SimpleAtoi(rest, &peak_kb));
      }
    }
    return peak_kb;
  }

  std::shared_ptr<grpc::Channel> Channel() const { return ChannelTo(address_); }
};

TEST_F(UntrustedClientTest, ServerRecoversFromExhaustedFileDescriptors) {
  Start();
  const rlimit few = {64, 64};
  ASSERT_EQ(prlimit(server_->process_id(), RLIMIT_NOFILE, &few, nullptr), 0);
  std::vector<int> connections;
  connections.reserve(100);
  for (int i = 0; i < 100; ++i) {
    connections.push_back(ConnectTo(address_));
  }
  for (const int connection : connections) {
    close(connection);
  }
  EXPECT_THAT(ConnectAs("")->GetCatalog(), IsOk());
}

TEST_F(UntrustedClientTest, ConnectionsLeaveDescriptorsForFiles) {
  Start();
  const auto client = ConnectAs("");
  ASSERT_THAT(client->GetCatalog(), IsOk());
  const rlimit few = {80, 80};  // 70 for connections, some of which the server has already
  ASSERT_EQ(prlimit(server_->process_id(), RLIMIT_NOFILE, &few, nullptr), 0);
  std::vector<int> connections;
  do {
    connections.push_back(ConnectTo(address_));
  } while (!IsClosed(connections.back()) && connections.size() < 80);
  EXPECT_TRUE(IsClosed(connections.back()));
  EXPECT_THAT(client->GetCatalog(), IsOk());
  for (const int connection : connections) {
    close(connection);
  }
  EXPECT_THAT(ConnectAs("")->GetCatalog(), IsOk()) << "new connections are accepted again";
  EXPECT_THAT(StopAndReadLog(), HasSubstr("event=connections_refused"));
}

TEST_F(UntrustedClientTest, CompressedRequestsAreRejected) {
  Start();
  const auto stub = v1::PoolService::NewStub(Channel());
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  v1::GetPoolRequest request;
  request.set_name(std::string(200 << 20, 'x'));
  v1::Pool pool;
  const int64_t before_kb = PeakKilobytes(server_->process_id());
  ASSERT_GT(before_kb, 0);
  EXPECT_EQ(stub->GetPool(&context, request, &pool).error_code(), grpc::StatusCode::UNIMPLEMENTED);
  const int64_t after_kb = PeakKilobytes(server_->process_id());
  ASSERT_GE(after_kb, before_kb);
  EXPECT_LT(after_kb - before_kb, 80 << 10);
}

TEST_F(UntrustedClientTest, StreamsWithoutAStartCountAsCalls) {
  Start({"--owner_call_count_max=3"});
  PoolStream learner(Channel());
  ASSERT_THAT(learner.Start(MazeSpec(1)), IsOk());
  // At least one of the four exceeds the limit, and any of them: the server starts calls on several
  // threads. A second one may, too, because a call counts until its response is sent.
  std::vector<std::unique_ptr<PoolStream>> runs(4);
  for (std::unique_ptr<PoolStream>& run : runs) {
    run = std::make_unique<PoolStream>(Channel());
  }
  std::vector<std::string> messages(runs.size());
  absl::Notification first_end;
  std::atomic<int> ends = 0;
  std::vector<std::thread> threads;
  for (size_t i = 0; i < runs.size(); ++i) {
    threads.emplace_back([&, i] {
      messages[i] = std::string(runs[i]->Finish().message());
      if (ends++ == 0) {
        first_end.Notify();
      }
    });
  }
  first_end.WaitForNotification();
  v1::Batch batch;
  EXPECT_THAT(learner.Step({4}, &batch), IsOk());
  for (const std::unique_ptr<PoolStream>& run : runs) {
    run->Cancel();
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_THAT(messages, testing::Contains("every caller together has 3 calls in progress and asks "
                                          "for 1 more, limit owner_call_count_max is 3"));
}

TEST_F(UntrustedClientTest, LongTextIsNotEchoed) {
  Start();
  v1::PoolSpec spec = MazeSpec(1);
  spec.add_games(std::string(1 << 20, 'x'));
  EXPECT_THAT(PoolStream(Channel()).Start(spec),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "spec.games[1] has 1048576 characters, allowed: the name of a game, at "
                       "most 64"));
  for (const absl::Status& status :
       {PoolStream(Channel()).Start(MazeSpec(1), {}, std::string(1 << 20, 'x')).status(),
        ConnectAs("")->GetPool(std::string(1 << 20, 'x')).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_LT(status.message().size(), 500U);
  }
}

}  // namespace
}  // namespace procgen
