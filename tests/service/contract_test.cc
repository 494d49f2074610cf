// Guarantees on responses that the comments of the protos give.

#include <algorithm>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/robustness/damaging_server.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"
#include "tests/service/stream/raw_stream.h"

namespace procgen {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::Ne;
using testing::SizeIs;

constexpr size_t kFrameBytes = 64UL * 64 * 3;

class ContractTest : public ServiceTest {};

v1::StepPoolRequest ResetRequest(int32_t environment) {
  v1::StepPoolRequest request;
  request.mutable_reset()->add_resets()->set_environment(environment);
  return request;
}

TEST_F(ContractTest, SkippedRowsRepeatTheLastStep) {
  v1::PoolSpec spec = MazeSpec(2);
  spec.set_games(0, "chaser");
  const auto stream = CreateAndAttach(spec);
  procgen_client::Batch batch;
  do {  // until an orb is eaten, which takes a few steps
    ASSERT_THAT(stream->Step({7, 7}, &batch), IsOk());
    ASSERT_LT(batch.sequence_number(), 100);
  } while (batch.rewards()[1] == 0);
  ASSERT_THAT(stream->Step({-1, -1}, &batch), IsOk());
  const BatchCopy stepped(batch);
  EXPECT_THAT(batch.terminated(), ElementsAre(true, true));
  for (int i = 0; i < 2; ++i) {
    ASSERT_THAT(stream->Observe(&batch), IsOk());
    EXPECT_EQ(BatchCopy(batch), stepped);
  }

  ASSERT_THAT(stream->Call(ResetRequest(0), &batch), IsOk());
  EXPECT_THAT(batch.terminated(), ElementsAre(false, true));
  EXPECT_EQ(batch.rewards()[1], stepped.rewards[1]);
  EXPECT_EQ(batch.episode_returns()[1], stepped.episode_returns[1]);
  EXPECT_THAT(batch.fingerprints(), ElementsAre(stepped.fingerprints[1]));
}

TEST_F(ContractTest, ResetRowsHaveThePreviousLevelAndNoReward) {
  const auto stream = CreateAndAttach(MazeSpec(2));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step({4, 4}, &batch), IsOk());
  const int32_t left = batch.level_seeds()[0];
  ASSERT_THAT(stream->Call(ResetRequest(0), &batch), IsOk());
  EXPECT_THAT(batch.first(), ElementsAre(true, false));
  EXPECT_THAT(batch.prev_level_seeds(), Contains(left));
  EXPECT_EQ(batch.prev_level_seeds()[0], left);
  EXPECT_THAT(batch.level_seeds()[0], Ne(left));
  EXPECT_THAT(batch.prev_level_complete(), ElementsAre(false, false));
  EXPECT_THAT(batch.terminated(), ElementsAre(false, false));
  EXPECT_THAT(batch.truncated(), ElementsAre(false, false));
  EXPECT_THAT(batch.rewards(), ElementsAre(0.0F, 0.0F));
  EXPECT_EQ(batch.episode_returns()[0], 0.0F);
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(0, 1));
}

TEST_F(ContractTest, ObserveReturnsObservationsAfterStepsWithoutThem) {
  const auto stream = CreateAndAttach(MazeSpec(2));
  const auto drawn = CreateAndAttach(MazeSpec(2));
  v1::StepPoolRequest request = StepRequest({7, 5});
  procgen_client::Batch expected;
  ASSERT_THAT(drawn->Call(request, &expected), IsOk());
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.observations(), SizeIs(0));
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  ASSERT_THAT(batch.observations(), SizeIs(2 * kFrameBytes));
  EXPECT_TRUE(std::equal(batch.observations().begin(), batch.observations().end(),
                         expected.observations().begin()));
}

TEST_F(ContractTest, RequestsMayBeSentBeforeAttachedArrives) {
  v1::Attach attach;
  attach.set_pool(CreatePool(MazeSpec(2)));
  const auto stub = v1::StepService::NewStub(channel_);
  RawStream stream(stub.get(), attach);
  stream.Send(StepRequest({4, 4}), 1);
  stream.Send(StepRequest({4, 4}), 2);
  stream.HalfClose();
  EXPECT_TRUE(stream.Receive().has_attached());
  EXPECT_EQ(stream.Receive().sequence_number(), 1);
  const v1::StepPoolResponse last = stream.Receive();
  EXPECT_EQ(last.sequence_number(), 2);
  EXPECT_THAT(last.batch().episode_lengths(), ElementsAre(2, 2));
  EXPECT_THAT(stream.Finish(), IsOk());
}

// A later server may send response kinds that this client does not know, here field 15.
TEST_F(ContractTest, ResponsesOfUnknownKindsAndNoRequestAreIgnored) {
  const std::string name = CreatePool(MazeSpec(1));
  v1::StepPoolResponse unknown;
  ASSERT_TRUE(unknown.ParseFromString(std::string("\x7a\x00", 2)));
  ASSERT_EQ(unknown.response_case(), v1::StepPoolResponse::RESPONSE_NOT_SET);
  DamagingServer between(
      channel_, 2, [](v1::StepPoolResponse* /*response*/) {}, unknown);
  const auto client = procgen_client::Client::Connect(between.address());
  ASSERT_THAT(client, IsOk());
  const auto stream = (*client)->Attach(name);
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  for (int step = 1; step <= 3; ++step) {
    ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
    EXPECT_THAT(batch.episode_lengths(), ElementsAre(step));
  }
}

}  // namespace
}  // namespace procgen
