// Learners that disconnect abruptly leak nothing.

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "grpcpp/create_channel_posix.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/service/pool_stream.h"
#include "tests/service/raw_call.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// Growth without a leak: caches of libraries.
constexpr int64_t kSettlingBytes = 16 << 20;

void CancelWithoutReading(const std::string& address) {
  PoolStream run(ChannelTo(address));
  run.Write(StartRequest(MazeSpec(1)));
  for (int i = 0; i < 3; ++i) {
    run.Write(StepRequest({4}));
  }
}

void CancelDuringARequest(const std::string& address) {
  PoolStream run(ChannelTo(address));
  EXPECT_THAT(run.Start(MazeSpec(16)), IsOk());
  run.Write(SliceStepRequest(0, 16, 4));
}

void HalfCloseWithoutReading(const std::string& address) {
  PoolStream run(ChannelTo(address));
  run.Write(StartRequest(MazeSpec(1)));
  run.Write(StepRequest({4}));
  run.HalfClose();
}

void SendInvalidRequest(const std::string& address) {
  PoolStream run(ChannelTo(address));
  EXPECT_THAT(run.Start(MazeSpec(1)), IsOk());
  EXPECT_FALSE(run.Call(StepRequest({99})).ok());
}

void LoseTheConnection(const std::string& address) {
  const int connection = ConnectTo(address);
  PoolStream run(grpc::CreateInsecureChannelFromFd("server", connection));
  EXPECT_THAT(run.Start(MazeSpec(1)), IsOk());
  run.Write(StepRequest({4}));
  shutdown(connection, SHUT_RDWR);
  EXPECT_FALSE(run.Finish().ok());
}

constexpr std::array kWays = {CancelWithoutReading, CancelDuringARequest, HalfCloseWithoutReading,
                              SendInvalidRequest, LoseTheConnection};

// Drops `rounds` pools of a server in this process, in all ways. Expects that the server then has
// no pools.
void ChurnPools(size_t rounds) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.worker_count = 2;
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  for (size_t round = 0; round < rounds; ++round) {
    kWays.at(round % kWays.size())((*server)->address());
  }
  const auto client = procgen_client::Client::Connect((*server)->address());
  ASSERT_THAT(client, IsOk());
  // The server detects a lost connection a little later.
  while ((*client)->GetLoad()->pool_count() > 0) {
  }
}

void ExpectNoGrowth(size_t rounds_before, size_t rounds) {
  ChurnPools(rounds_before);
  const int64_t bytes_before = AllocatedBytes();
  const int64_t files_before = ProcessResources::Of(getpid()).file_count;
  ChurnPools(rounds);
  EXPECT_LT(AllocatedBytes(), bytes_before + kSettlingBytes);
  EXPECT_LE(ProcessResources::Of(getpid()).file_count, files_before);
}

TEST(ChurnTest, MemoryAndFilesDoNotGrow) { ExpectNoGrowth(60, 240); }

TEST(ChurnSlowTest, MemoryAndFilesDoNotGrowOverTenThousandPools) { ExpectNoGrowth(500, 10'000); }

}  // namespace
}  // namespace procgen
