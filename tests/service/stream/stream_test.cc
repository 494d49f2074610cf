// Valid streams.

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::SizeIs;

constexpr size_t kFrameBytes = 64UL * 64 * 3;

class StreamTest : public ServiceTest {};

TEST_F(StreamTest, ObserveReturnsTheFirstObservations) {
  const auto stream = StartPool(MazeSpec(3));
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_EQ(batch.first_env(), 0);
  EXPECT_EQ(batch.env_count(), 3);
  EXPECT_THAT(batch.first(), ElementsAre(true, true, true));
  EXPECT_THAT(batch.rewards(), Each(0.0F));
  EXPECT_THAT(batch.episode_lengths(), Each(0));
  EXPECT_THAT(batch.prev_level_seeds(), Each(0));
  EXPECT_THAT(batch.observations(), SizeIs(3 * kFrameBytes));
}

TEST_F(StreamTest, StepReturnsEveryArray) {
  const auto stream = StartPool(MazeSpec(3));
  v1::Batch batch;
  ASSERT_THAT(stream->Step({4, 4, -1}, &batch), IsOk());
  EXPECT_THAT(batch.first(), ElementsAre(false, false, true));
  EXPECT_THAT(batch.terminated(), ElementsAre(false, false, true));
  EXPECT_THAT(batch.truncated(), ElementsAre(false, false, false));
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(1, 1, 1));
  EXPECT_THAT(batch.rewards(), SizeIs(3));
  EXPECT_THAT(batch.prev_level_complete(), SizeIs(3));
  EXPECT_THAT(batch.episode_returns(), SizeIs(3));
  EXPECT_EQ(batch.level_seeds()[0], batch.prev_level_seeds()[0]);
  EXPECT_THAT(batch.observations(), SizeIs(3 * kFrameBytes));
  EXPECT_THAT(batch.final_observations(), SizeIs(0));
}

TEST_F(StreamTest, ObservationsAreOmittedOnRequest) {
  const auto stream = StartPool(MazeSpec(2));
  v1::RunPoolRequest request = StepRequest({4, 4});
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.observations(), SizeIs(0));
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(1, 1));
}

TEST_F(StreamTest, SlicesStepOnlyTheirEnvironments) {
  const auto stream = StartPool(MazeSpec(5));
  v1::Batch batch;
  ASSERT_THAT(stream->Call(SliceStepRequest(1, 2, 4), &batch), IsOk());
  EXPECT_EQ(batch.first_env(), 1);
  EXPECT_EQ(batch.env_count(), 2);
  EXPECT_THAT(batch.observations(), SizeIs(2 * kFrameBytes));
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(0, 1, 1, 0, 0));
}

TEST_F(StreamTest, RepeatSumsRewardsAndCountsSteps) {
  const auto stream = StartPool(MazeSpec(2));
  v1::RunPoolRequest request = StepRequest({4, 4});
  request.mutable_step()->set_repeat_count(7);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(7, 7));
}

TEST_F(StreamTest, RepeatStopsAtTheEndOfAnEpisode) {
  const auto stream = StartPool(MazeSpec(1));
  v1::RunPoolRequest request = StepRequest({-1});
  request.mutable_step()->set_repeat_count(7);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(1));
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_THAT(batch.first(), ElementsAre(true));
}

TEST_F(StreamTest, NextLevelIsPlayedAfterTheEpisode) {
  const auto stream = StartPool(MazeSpec(2));
  v1::RunPoolRequest request = StepRequest({4, 4});
  v1::NextLevel* next = request.mutable_step()->add_next_levels();
  next->set_environment(1);
  next->set_level_seed(4711);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_NE(batch.level_seeds()[1], 4711);
  ASSERT_THAT(stream->Step({4, -1}, &batch), IsOk());
  EXPECT_EQ(batch.level_seeds()[1], 4711);
}

TEST_F(StreamTest, ResetRestartsChosenEnvironments) {
  const auto stream = StartPool(MazeSpec(4));
  v1::Batch batch;
  ASSERT_THAT(stream->Step({4, 4, 4, 4}, &batch), IsOk());
  v1::RunPoolRequest request = ResetRequest(4);
  for (const int32_t environment : {3, 1}) {
    v1::Reset* reset = request.mutable_reset()->add_resets();
    reset->set_environment(environment);
    reset->set_level_seed(100 + environment);
  }
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.env_count(), 4);
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(1, 0, 1, 0));
  EXPECT_EQ(batch.level_seeds()[1], 101);
  EXPECT_EQ(batch.level_seeds()[3], 103);
  EXPECT_TRUE(batch.first()[1]);
  EXPECT_THAT(batch.observations(), SizeIs(4 * kFrameBytes));
}

TEST_F(StreamTest, ResetWithRandSeedRepeatsTheLevels) {
  const auto stream = StartPool(MazeSpec(1));
  v1::RunPoolRequest request = ResetRequest(1);
  request.mutable_reset()->add_resets()->set_rand_seed(99);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  const int32_t level_seed = batch.level_seeds()[0];
  ASSERT_THAT(stream->Step({-1}, &batch), IsOk());
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.level_seeds()[0], level_seed);
}

TEST_F(StreamTest, StepDoesNotStepResetEnvironments) {
  const auto stream = StartPool(MazeSpec(2));
  v1::Batch batch;
  ASSERT_THAT(stream->Step({4, 4}, &batch), IsOk());
  v1::RunPoolRequest request = StepRequest({4, 4});
  request.mutable_step()->add_resets()->set_environment(1);
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(2, 0));
  EXPECT_THAT(batch.first(), ElementsAre(false, true));
}

TEST_F(StreamTest, FinalObservationsPrecedeTheReset) {
  // Without automatic resets, the observation of a step that ends the episode is the final one.
  v1::PoolSpec spec = MazeSpec(3);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  v1::Batch expected;
  ASSERT_THAT(StartPool(spec)->Step({4, -1, -1}, &expected), IsOk());
  const auto stream = StartPool(MazeSpec(3));
  v1::RunPoolRequest request = StepRequest({4, -1, -1});
  request.mutable_step()->set_with_final_observations(true);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.final_observations(), expected.observations().substr(kFrameBytes));
  EXPECT_NE(batch.observations(), expected.observations());
}

TEST_F(StreamTest, StartedContainsThePool) {
  PoolStream run(channel_);
  const auto started = run.Start(MazeSpec(3), {}, "mine");
  ASSERT_THAT(started, IsOk());
  EXPECT_EQ(started->pool().name(), "pools/mine");
  const auto catalog = client_->GetCatalog();
  ASSERT_THAT(catalog, IsOk());
  EXPECT_EQ(started->server_version(), catalog->server_version());
  EXPECT_NE(started->art_fingerprint(), 0U);
}

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

TEST_F(StreamTest, ConcurrentLearnersAreIndependent) {
  const auto learn = [](PoolStream* stream, std::vector<int32_t>* level_seeds) {
    v1::Batch batch;
    for (int32_t i = 0; i < 200; ++i) {
      const std::vector<int32_t> actions(16, i % 10 == 9 ? -1 : i % 9);
      ASSERT_THAT(stream->Step(actions, &batch), IsOk());
      level_seeds->insert(level_seeds->end(), batch.level_seeds().begin(),
                          batch.level_seeds().end());
    }
  };
  std::vector<int32_t> first;
  std::vector<int32_t> second;
  const auto first_stream = StartPool(MazeSpec(16));
  const auto second_stream = StartPool(MazeSpec(16));
  std::thread other([&] { learn(second_stream.get(), &second); });
  learn(first_stream.get(), &first);
  other.join();
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace procgen
