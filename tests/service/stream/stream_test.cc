// Valid streams.

#include <thread>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr size_t kFrameBytes = 64UL * 64 * 3;

class StreamTest : public ServiceTest {};

TEST_F(StreamTest, RequestsSentAheadAreAnsweredInOrder) {
  PoolStream run(channel_);
  run.Write(StartRequest(MazeSpec(4)));
  for (int i = 0; i < 4; ++i) {
    run.Write(SliceStepRequest(i, 1, 4));
  }
  run.HalfClose();
  EXPECT_TRUE(run.Read()->has_started());
  v1::Batch batch;
  for (int i = 0; i < 4; ++i) {
    ASSERT_THAT(run.Read(&batch), IsOk());
    EXPECT_EQ(batch.first_env(), i);
  }
  EXPECT_THAT(run.Read(), StatusIs(absl::StatusCode::kOutOfRange, testing::_));
  EXPECT_THAT(run.Finish(), IsOk());
}

// A single environment is stepped on the thread that received the request, within the read
// callback.
TEST_F(StreamTest, AnyNumberOfRequestsMayBeSentAhead) {
  constexpr int32_t kStepCount = 20'000;
  const auto stream = StartPool(MazeSpec(1));
  v1::RunPoolRequest request = StepRequest({4});
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  std::thread writer([&] {
    for (int32_t i = 0; i < kStepCount; ++i) {
      stream->Write(request);
    }
  });
  v1::Batch batch;
  int32_t received = 0;
  while (received < kStepCount && stream->Read(&batch).ok()) {
    ++received;
  }
  writer.join();
  EXPECT_EQ(received, kStepCount);
}

TEST_F(StreamTest, PoolEndsWithItsStream) {
  const auto closed = StartPool(MazeSpec(1));
  EXPECT_THAT(client_->GetPool(closed->name()), IsOk());
  EXPECT_THAT(closed->Close(), IsOk());
  EXPECT_THAT(client_->GetPool(closed->name()),
              StatusIs(absl::StatusCode::kNotFound, "there is no pool " + closed->name()));

  const auto cancelled = StartPool(MazeSpec(64));
  for (int i = 0; i < 2; ++i) {
    cancelled->Write(SliceStepRequest(0, 64, 4));
  }
  cancelled->Cancel();
  EXPECT_THAT(cancelled->Finish(), StatusIs(absl::StatusCode::kCancelled, testing::_));
  // The server detects the cancellation a little later.
  while (client_->GetPool(cancelled->name()).ok()) {
  }
}

TEST_F(StreamTest, AcknowledgedStepsHaveTheSameEffect) {
  const auto stream = StartPool(MazeSpec(2));
  const auto expected = StartPool(MazeSpec(2));
  v1::RunPoolRequest request = StepRequest({7, -1});
  v1::Batch expected_batch;
  ASSERT_THAT(expected->Call(request, &expected_batch), IsOk());
  request.mutable_step()->set_acknowledge_only(true);
  const auto response = stream->Call(request);
  ASSERT_THAT(response, IsOk());
  EXPECT_TRUE(response->has_ack());
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  ASSERT_THAT(expected->Observe(&expected_batch), IsOk());
  EXPECT_TRUE(EqualMessages(batch, expected_batch));
}

}  // namespace
}  // namespace procgen
