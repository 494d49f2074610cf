// Guarantees on responses that the comments of the protos give.

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::Ne;
using testing::SizeIs;

constexpr size_t kFrameBytes = 64UL * 64 * 3;

class ContractTest : public ServiceTest {};

v1::RunPoolRequest ResetOfEnvironment(int32_t environment) {
  v1::RunPoolRequest request = ResetRequest(2);
  request.mutable_reset()->add_resets()->set_environment(environment);
  return request;
}

TEST_F(ContractTest, SkippedRowsRepeatTheLastStep) {
  v1::PoolSpec spec = MazeSpec(2);
  spec.set_games(0, "chaser");
  const auto stream = StartPool(spec);
  v1::Batch batch;
  do {  // until an orb is eaten, which takes a few steps
    ASSERT_THAT(stream->Step({7, 7}, &batch), IsOk());
    ASSERT_LT(batch.episode_lengths(0), 100);
  } while (batch.rewards()[1] == 0);
  ASSERT_THAT(stream->Step({-1, -1}, &batch), IsOk());
  const v1::Batch stepped = batch;
  EXPECT_THAT(batch.terminated(), ElementsAre(true, true));
  for (int i = 0; i < 2; ++i) {
    ASSERT_THAT(stream->Observe(&batch), IsOk());
    EXPECT_TRUE(EqualMessages(batch, stepped));
  }

  ASSERT_THAT(stream->Call(ResetOfEnvironment(0), &batch), IsOk());
  EXPECT_THAT(batch.terminated(), ElementsAre(false, true));
  EXPECT_EQ(batch.rewards()[1], stepped.rewards(1));
  EXPECT_EQ(batch.episode_returns()[1], stepped.episode_returns(1));
  EXPECT_THAT(batch.fingerprints(), ElementsAre(stepped.fingerprints(1)));
}

TEST_F(ContractTest, ResetRowsHaveThePreviousLevelAndNoReward) {
  const auto stream = StartPool(MazeSpec(2));
  v1::Batch batch;
  ASSERT_THAT(stream->Step({4, 4}, &batch), IsOk());
  const int32_t left = batch.level_seeds()[0];
  ASSERT_THAT(stream->Call(ResetOfEnvironment(0), &batch), IsOk());
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
  const auto stream = StartPool(MazeSpec(2));
  const auto drawn = StartPool(MazeSpec(2));
  v1::RunPoolRequest request = StepRequest({7, 5});
  v1::Batch expected;
  ASSERT_THAT(drawn->Call(request, &expected), IsOk());
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.observations(), SizeIs(0));
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  ASSERT_THAT(batch.observations(), SizeIs(2 * kFrameBytes));
  EXPECT_TRUE(batch.observations() == expected.observations());
}

}  // namespace
}  // namespace procgen
