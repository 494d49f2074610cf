// A learner that does not read blocks only itself, and uses a bounded share of memory.

#include <vector>

#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/pool_stream.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int32_t kEnvCount = 300;  // a response takes 3.7 MB
constexpr int64_t kRequestCount = 64;
constexpr int64_t kReadAhead = 16;
// The responses that the server and the connection hold.
constexpr int64_t kExecutedMax = 6;
// Allows a few responses and other allocations. Measured: 27 MB. All responses would take 236 MB.
#ifdef __SANITIZE_THREAD__
constexpr int64_t kMemoryBytesMax = 5 * (48 << 20);  // four shadow bytes per byte
#else
constexpr int64_t kMemoryBytesMax = 48 << 20;
#endif

TEST(BackpressureTest, LearnerThatDoesNotReadBlocksOnlyItself) {
  ReturnFreedMemoryAtOnce();
  ServerProcess process({"--address=127.0.0.1:0", "--workers=2", "--log_level=error"});
  const std::string address = process.Address();
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  PoolStream other(ChannelTo(address));
  ASSERT_THAT(other.Start(MazeSpec(4)), IsOk());
  PoolStream unread(ChannelTo(address));
  ASSERT_THAT(unread.Start(MazeSpec(kEnvCount)), IsOk());

  const int64_t memory_before = ProcessResources::Of(process.process_id()).memory_bytes;
  const int64_t received_before = (*client)->GetLoad()->stream_received_bytes();
  const v1::RunPoolRequest request = SliceStepRequest(0, kEnvCount, 4);
  for (int64_t number = 1; number <= kRequestCount; ++number) {
    ASSERT_TRUE(unread.Write(request));
  }
  const v1::RunPoolRequest other_request = SliceStepRequest(0, 4, 4);
  v1::Batch batch;
  int64_t other_bytes = 0;
  for (int step = 0; step < 200; ++step) {
    ASSERT_THAT(other.Call(other_request, &batch), IsOk());
    other_bytes += static_cast<int64_t>(other_request.ByteSizeLong());
  }
  EXPECT_LT((*client)->GetPool(unread.name())->request_count(), kExecutedMax);
  EXPECT_LT(ProcessResources::Of(process.process_id()).memory_bytes,
            memory_before + kMemoryBytesMax);
  const int64_t received =
      (*client)->GetLoad()->stream_received_bytes() - received_before - other_bytes;
  EXPECT_LE(received / static_cast<int64_t>(request.ByteSizeLong()), kReadAhead + kExecutedMax);
  EXPECT_GE(received / static_cast<int64_t>(request.ByteSizeLong()), kReadAhead);

  // Reading returns all responses.
  for (int32_t number = 1; number <= kRequestCount; ++number) {
    ASSERT_THAT(unread.Read(&batch), IsOk());
  }
  EXPECT_EQ((*client)->GetPool(unread.name())->request_count(), kRequestCount);
  EXPECT_THAT(unread.Close(), IsOk());
}

}  // namespace
}  // namespace procgen
