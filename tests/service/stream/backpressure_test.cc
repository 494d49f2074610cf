// A learner that does not read blocks only itself, and uses a bounded share of memory.

#include <memory>
#include <vector>

#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 300;  // fit one response of 3.7 MB
constexpr int64_t kRequestCount = 64;
constexpr int32_t kInFlightMax = 16;
// Allows a few responses, their serialized copies and other allocations. Measured: 27 MB, or 38 MB
// with a resume buffer. All responses would take 236 MB.
#ifdef __SANITIZE_THREAD__
constexpr int64_t kMemoryBytesMax = 5 * (48 << 20);  // four shadow bytes per byte
#else
constexpr int64_t kMemoryBytesMax = 48 << 20;
#endif

class BackpressureTest : public testing::TestWithParam<bool> {};

TEST_P(BackpressureTest, LearnerThatDoesNotReadBlocksOnlyItself) {
  ReturnFreedMemoryAtOnce();
  ServerProcess process({"--address=127.0.0.1:0", "--workers=2", "--log_level=error"});
  const std::string address = process.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const auto other = (*client)->Attach((*client)->CreatePool(MazeSpec(4))->name());
  ASSERT_THAT(other, IsOk());
  const std::string pool = (*client)->CreatePool(MazeSpec(kEnvCount))->name();

  const auto stub =
      v1::StepService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  const auto unread = stub->StepPool(&context);
  v1::StepPoolRequest request;
  request.mutable_attach()->set_pool(pool);
  request.mutable_attach()->set_requests_in_flight_max(kInFlightMax);
  request.mutable_attach()->set_resumable(GetParam());
  v1::StepPoolResponse response;
  ASSERT_TRUE(unread->Write(request) && unread->Read(&response));
  const int64_t before = ProcessResources::Of(process.process_id()).memory_bytes;
  for (int64_t number = 1; number <= kRequestCount; ++number) {
    request = StepRequest(std::vector<int32_t>(kEnvCount, 4));
    request.set_sequence_number(number);
    ASSERT_TRUE(unread->Write(request));
  }
  procgen_client::Batch batch;
  for (int step = 0; step < 200; ++step) {
    ASSERT_THAT((*other)->Step({4, 4, 4, 4}, &batch), IsOk());
  }
  EXPECT_LT((*client)->GetPool(pool)->next_sequence_number(), 6);
  EXPECT_LT(ProcessResources::Of(process.process_id()).memory_bytes, before + kMemoryBytesMax);

  // Reading returns all responses.
  for (int64_t number = 1; number <= kRequestCount; ++number) {
    ASSERT_TRUE(unread->Read(&response));
    EXPECT_EQ(response.sequence_number(), number);
  }
  unread->WritesDone();
  EXPECT_FALSE(unread->Read(&response));
  EXPECT_TRUE(unread->Finish().ok());
}

INSTANTIATE_TEST_SUITE_P(Resumable, BackpressureTest, testing::Bool());

}  // namespace
}  // namespace procgen
