#include "tests/service/robustness/churn.h"

#include <malloc.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/service/pool_stream.h"
#include "tests/service/robustness/broken_connection.h"
#include "tests/service/robustness/fault_proxy.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// A function of the sanitizers' allocator; GCC has no header for it.
extern "C" size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace procgen {
namespace {

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

void RecoverAndLeave(const std::string& address) {
  FaultProxy proxy({.target = address, .bytes_between_faults = 30'000});
  const auto pool = CreateRemotePool(proxy.address(), {"maze"}, 1);
  std::vector<uint8_t> observations(kObservationBytes);
  Batch batch;
  batch.observations = absl::MakeSpan(observations);
  const int32_t action = 4;
  proxy.SetFaults(true);
  while (proxy.break_count() < 2) {
    ASSERT_THAT(pool->Step({.count = 1, .actions = {&action, 1}}, {}, batch), IsOk());
  }
  proxy.SetFaults(false);
}

constexpr std::array kWays = {CancelWithoutReading, CancelDuringARequest, HalfCloseWithoutReading,
                              SendInvalidRequest,   LoseTheConnection,    RecoverAndLeave};

}  // namespace

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

void DropPool(const std::string& address, size_t way) { kWays.at(way % kWays.size())(address); }

void ChurnPools(size_t rounds) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.worker_count = 2;
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  for (size_t round = 0; round < rounds; ++round) {
    DropPool((*server)->address(), round);
  }
  const auto client = procgen_client::Client::Connect((*server)->address());
  ASSERT_THAT(client, IsOk());
  // The server detects a lost connection a little later.
  while ((*client)->GetLoad()->pool_count() > 0) {
  }
}

}  // namespace procgen
