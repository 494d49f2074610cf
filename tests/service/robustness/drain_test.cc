// A draining server, seen by its clients.

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/raw_call.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class DrainTest : public ServiceTest {};

TEST_F(DrainTest, DrainRejectsPoolsAndEndsStreams) {
  const auto stream = StartPool(MazeSpec(1));
  server_is_alive_ = false;
  server_->BeginDrain();
  EXPECT_THAT(CallRaw(channel_, "/grpc.health.v1.Health/Check", {""}).responses,
              testing::ElementsAre("\x08\x02"));  // NOT_SERVING
  PoolStream rejected(channel_);
  EXPECT_THAT(rejected.Start(MazeSpec(1)),
              StatusIs(absl::StatusCode::kUnavailable,
                       "the server drains and will stop; use another server"));
  EXPECT_TRUE(rejected.drained());
  EXPECT_THAT(stream->Finish(), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_TRUE(stream->drained());
  const absl::StatusOr<v1::Load> load = client_->GetLoad();
  ASSERT_THAT(load, IsOk());
  EXPECT_TRUE(load->draining());
}

TEST_F(DrainTest, RunningRequestIsAnsweredAndLaterOnesAreNotExecuted) {
  constexpr int kRequestCount = 10;
  const auto stream = StartPool(MazeSpec(100));
  v1::RunPoolRequest request = SliceStepRequest(0, 100, 4);
  request.mutable_step()->set_repeat_count(1000);  // takes a while, in which the others arrive
  for (int i = 0; i < kRequestCount; ++i) {
    stream->Write(request);
  }
  v1::Batch batch;
  ASSERT_THAT(stream->Read(&batch), IsOk());
  server_is_alive_ = false;
  server_->BeginDrain();
  int answered = 1;
  absl::Status status;
  while ((status = stream->Read(&batch)).ok()) {
    ++answered;
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_TRUE(stream->drained());
  EXPECT_LT(answered, kRequestCount);
  EXPECT_EQ(client_->GetLoad()->step_count(), 100 * answered);
}

TEST_F(DrainTest, LearnerThatDoesNotReadIsDisconnectedAtTheTimeout) {
  // The responses are not read, so they cannot be sent.
  const auto stream = StartPool(MazeSpec(400));
  for (int i = 1; i <= 3; ++i) {
    stream->Write(SliceStepRequest(0, 400, 4));
  }
  server_is_alive_ = false;
  server_->Stop(absl::Milliseconds(100));
  EXPECT_FALSE(stream->Finish().ok());
}

}  // namespace
}  // namespace procgen
