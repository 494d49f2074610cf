#include "tests/service/robustness/churn.h"

#include <malloc.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/service/robustness/fault_proxy.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// A function of the sanitizers' allocator; GCC has no header for it.
extern "C" size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace procgen {
namespace {

using procgen_client::Batch;
using procgen_client::Client;

// A server, the pool of this round, and a second client that interferes.
struct Scene {
  std::string address;
  Client* other = nullptr;
  std::string pool;
  int round = 0;
};

std::unique_ptr<Client> ConnectTo(const std::string& address) {
  absl::StatusOr<std::unique_ptr<Client>> client = Client::Connect(address);
  EXPECT_THAT(client, IsOk());
  return *std::move(client);
}

void CancelWithoutReading(const Scene& scene) {
  const auto channel = grpc::CreateChannel(scene.address, grpc::InsecureChannelCredentials());
  const auto stub = v1::StepService::NewStub(channel);
  grpc::ClientContext context;
  const auto stream = stub->StepPool(&context);
  v1::StepPoolRequest request;
  request.mutable_attach()->set_pool(scene.pool);
  request.mutable_attach()->set_resumable(scene.round % 2 == 0);
  stream->Write(request);
  for (int64_t number = 1; number <= 3; ++number) {
    request = StepRequest({4});
    request.set_sequence_number(number);
    stream->Write(request);
  }
  context.TryCancel();
  stream->Finish();
}

void DeletePoolUnderTheStream(const Scene& scene) {
  const auto stream = scene.other->Attach(scene.pool);
  EXPECT_THAT(stream, IsOk());
  EXPECT_THAT((*stream)->Send(StepRequest({4})), IsOk());
  EXPECT_THAT(scene.other->DeletePool(scene.pool), IsOk());
}

void SendInvalidRequest(const Scene& scene) {
  Batch batch;
  EXPECT_FALSE((*scene.other->Attach(scene.pool))->Step({99}, &batch).ok());
}

void TakeOverTwice(const Scene& scene) {
  const auto client = ConnectTo(scene.address);
  const auto first = client->Attach(scene.pool);
  EXPECT_THAT((*first)->Send(StepRequest({4})), IsOk());
  const auto second = scene.other->Attach(scene.pool, {.take_over = true});
  EXPECT_THAT(second, IsOk());
}

void LoseTheConnection(const Scene& scene) {
  Batch batch;
  FaultProxy proxy({.target = scene.address});
  const auto client = ConnectTo(proxy.address());
  const auto stream = client->Attach(scene.pool, {.reconnect_timeout = absl::ZeroDuration()});
  proxy.SetFaults(true);
  for (int i = 0; i < 10; ++i) {
    if (!(*stream)->Step({4}, &batch).ok()) {
      break;
    }
  }
}

void ResumeAndLeave(const Scene& scene) {
  Batch batch;
  FaultProxy proxy({.target = scene.address, .bytes_between_faults = 30'000});
  const auto client = ConnectTo(proxy.address());
  const auto stream = client->Attach(scene.pool);
  proxy.SetFaults(true);
  while (proxy.break_count() < 2) {
    EXPECT_THAT((*stream)->Step({4}, &batch), IsOk());
  }
  proxy.SetFaults(false);
}

constexpr std::array kFaults = {CancelWithoutReading, DeletePoolUnderTheStream, SendInvalidRequest,
                                TakeOverTwice,        LoseTheConnection,        ResumeAndLeave};

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

void ChurnPools(int rounds) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.worker_count = 2;
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const std::string address = (*server)->address();
  const auto other = ConnectTo(address);
  for (int round = 0; round < rounds; ++round) {
    const auto pool = other->CreatePool(MazeSpec(1));
    ASSERT_THAT(pool, IsOk());
    kFaults[static_cast<size_t>(round) % kFaults.size()](
        {address, other.get(), pool->name(), round});
    other->DeletePool(pool->name()).IgnoreError();
  }
  // The server detects a lost connection a little later.
  while (other->GetLoad()->stream_count() > 0) {
  }
  EXPECT_EQ(other->GetLoad()->pool_count(), 0);
}

}  // namespace procgen
