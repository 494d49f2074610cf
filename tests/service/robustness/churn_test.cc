// Learners that disconnect abruptly leak nothing.

#include <malloc.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/service/pool_stream.h"
#include "tests/service/robustness/fault_proxy.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// A function of the sanitizers' allocator; GCC has no header for it.
extern "C" size_t __sanitizer_get_current_allocated_bytes();
#endif

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
  auto proxy = std::make_unique<FaultProxy>(FaultProxy::Options{.target = address});
  PoolStream run(ChannelTo(proxy->address()));
  EXPECT_THAT(run.Start(MazeSpec(1)), IsOk());
  run.Write(StepRequest({4}));
  proxy = nullptr;
  EXPECT_FALSE(run.Finish().ok());
}

constexpr std::array kWays = {CancelWithoutReading, CancelDuringARequest, HalfCloseWithoutReading,
                              SendInvalidRequest, LoseTheConnection};

// Memory and files in use by this process, without free memory that the allocator keeps.
ProcessResources ResourcesInUse() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  // Resident memory would include shadow memory and freed memory.
  ProcessResources process_resources = ProcessResources::Of(getpid());
  process_resources.memory_bytes = static_cast<int64_t>(__sanitizer_get_current_allocated_bytes());
  return process_resources;
#else
  malloc_trim(0);
  return ProcessResources::Of(getpid());
#endif
}

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
  const ProcessResources before = ResourcesInUse();
  ChurnPools(rounds);
  const ProcessResources after = ResourcesInUse();
  EXPECT_LT(after.memory_bytes, before.memory_bytes + kSettlingBytes);
  EXPECT_LE(after.file_count, before.file_count);
}

TEST(ChurnTest, MemoryAndFilesDoNotGrow) { ExpectNoGrowth(60, 240); }

TEST(ChurnSlowTest, MemoryAndFilesDoNotGrowOverTenThousandPools) { ExpectNoGrowth(500, 10'000); }

}  // namespace
}  // namespace procgen
