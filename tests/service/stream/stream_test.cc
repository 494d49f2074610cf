// Valid StepPool streams.

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
  const auto stream = CreateAndAttach(MazeSpec(3));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_EQ(batch.sequence_number(), 1);
  EXPECT_EQ(batch.first_env(), 0);
  EXPECT_EQ(batch.env_count(), 3);
  EXPECT_THAT(batch.first(), ElementsAre(true, true, true));
  EXPECT_THAT(batch.rewards(), Each(0.0F));
  EXPECT_THAT(batch.episode_lengths(), Each(0));
  EXPECT_THAT(batch.prev_level_seeds(), Each(0));
  EXPECT_THAT(batch.observations(), SizeIs(3 * kFrameBytes));
}

TEST_F(StreamTest, StepReturnsEveryArray) {
  const auto stream = CreateAndAttach(MazeSpec(3));
  procgen_client::Batch batch;
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
  const auto stream = CreateAndAttach(MazeSpec(2));
  v1::StepPoolRequest request = StepRequest({4, 4});
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.observations(), SizeIs(0));
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(1, 1));
}

TEST_F(StreamTest, SlicesStepOnlyTheirEnvironments) {
  const auto stream = CreateAndAttach(MazeSpec(5));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(SliceStepRequest(1, 2, 4), &batch), IsOk());
  EXPECT_EQ(batch.first_env(), 1);
  EXPECT_EQ(batch.env_count(), 2);
  EXPECT_THAT(batch.observations(), SizeIs(2 * kFrameBytes));
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(0, 1, 1, 0, 0));
}

TEST_F(StreamTest, RepeatSumsRewardsAndCountsSteps) {
  const auto stream = CreateAndAttach(MazeSpec(2));
  v1::StepPoolRequest request = StepRequest({4, 4});
  request.mutable_step()->set_repeat_count(7);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(7, 7));
}

TEST_F(StreamTest, RepeatStopsAtTheEndOfAnEpisode) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  v1::StepPoolRequest request = StepRequest({-1});
  request.mutable_step()->set_repeat_count(7);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(1));
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_THAT(batch.first(), ElementsAre(true));
}

TEST_F(StreamTest, NextLevelIsPlayedAfterTheEpisode) {
  const auto stream = CreateAndAttach(MazeSpec(2));
  v1::StepPoolRequest request = StepRequest({4, 4});
  v1::NextLevel* next = request.mutable_step()->add_next_levels();
  next->set_environment(1);
  next->set_level_seed(4711);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_NE(batch.level_seeds()[1], 4711);
  ASSERT_THAT(stream->Step({4, -1}, &batch), IsOk());
  EXPECT_EQ(batch.level_seeds()[1], 4711);
}

TEST_F(StreamTest, ResetRestartsChosenEnvironments) {
  const auto stream = CreateAndAttach(MazeSpec(4));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step({4, 4, 4, 4}, &batch), IsOk());
  v1::StepPoolRequest request;
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
  const auto stream = CreateAndAttach(MazeSpec(1));
  v1::StepPoolRequest request;
  request.mutable_reset()->add_resets()->set_rand_seed(99);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  const int32_t level_seed = batch.level_seeds()[0];
  ASSERT_THAT(stream->Step({-1}, &batch), IsOk());
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.level_seeds()[0], level_seed);
}

TEST_F(StreamTest, StepDoesNotStepResetEnvironments) {
  const auto stream = CreateAndAttach(MazeSpec(2));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step({4, 4}, &batch), IsOk());
  v1::StepPoolRequest request = StepRequest({4, 4});
  request.mutable_step()->add_resets()->set_environment(1);
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(2, 0));
  EXPECT_THAT(batch.first(), ElementsAre(false, true));
}

TEST_F(StreamTest, FinalObservationsPrecedeTheReset) {
  // Without automatic resets, the observation of a step that ends the episode is the final one.
  v1::PoolSpec spec = MazeSpec(3);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  procgen_client::Batch expected;
  ASSERT_THAT(CreateAndAttach(spec)->Step({4, -1, -1}, &expected), IsOk());
  const auto stream = CreateAndAttach(MazeSpec(3));
  v1::StepPoolRequest request = StepRequest({4, -1, -1});
  request.mutable_step()->set_with_final_observations(true);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.final_observations(), expected.observations().subspan(kFrameBytes));
  EXPECT_NE(batch.observations(), expected.observations());
}

TEST_F(StreamTest, RequestsSentAheadAreAnsweredInOrder) {
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = 4;
  const auto stream = CreateAndAttach(MazeSpec(4), options);
  EXPECT_EQ(stream->requests_in_flight_max(), 4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(*stream->Send(SliceStepRequest(i, 1, 4)), i + 1);
  }
  EXPECT_THAT(stream->Send(StepRequest({4})), StatusIs(absl::StatusCode::kFailedPrecondition,
                                                       "4 requests are unanswered, allowed: 4"));
  procgen_client::Batch batch;
  for (int i = 0; i < 4; ++i) {
    ASSERT_THAT(stream->Receive(&batch), IsOk());
    EXPECT_EQ(batch.sequence_number(), i + 1);
    EXPECT_EQ(batch.first_env(), i);
  }
}

// A single environment is stepped on the thread that received the request, within the read
// callback.
TEST_F(StreamTest, OneEnvironmentExecutesManyRequestsSentAhead) {
  constexpr int64_t kStepCount = 20'000;
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = 8;  // the limit of this server
  const auto stream = CreateAndAttach(MazeSpec(1), options);
  v1::StepPoolRequest request = StepRequest({4});
  request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  procgen_client::Batch batch;
  int64_t sent = 0;
  for (int64_t received = 0; received < kStepCount; ++received) {
    for (; sent < std::min(kStepCount, received + options.requests_in_flight_max); ++sent) {
      ASSERT_THAT(stream->Send(request), IsOk());
    }
    ASSERT_THAT(stream->Receive(&batch), IsOk());
    ASSERT_EQ(batch.sequence_number(), received + 1);
  }
}

TEST_F(StreamTest, LearnerBeyondItsWindowIsPausedNotFailed) {
  const auto stub = v1::StepService::NewStub(channel_);
  grpc::ClientContext context;
  const auto stream = stub->StepPool(&context);
  v1::StepPoolRequest attach;
  attach.mutable_attach()->set_pool(CreatePool(MazeSpec(64)));
  ASSERT_TRUE(stream->Write(attach));
  constexpr int kRequests = 200;
  std::thread writer([&] {
    for (int i = 1; i <= kRequests; ++i) {
      v1::StepPoolRequest request = StepRequest(std::vector<int32_t>(64, 4));
      request.set_sequence_number(i);
      stream->Write(request);
    }
    stream->WritesDone();
  });
  v1::StepPoolResponse response;
  ASSERT_TRUE(stream->Read(&response));
  for (int i = 1; i <= kRequests; ++i) {
    ASSERT_TRUE(stream->Read(&response));
    ASSERT_EQ(response.sequence_number(), i);
  }
  EXPECT_FALSE(stream->Read(&response));
  writer.join();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(StreamTest, LargePoolIsSplitIntoResponsesOfFourMebibytes) {
  const auto stub = v1::StepService::NewStub(channel_);
  grpc::ClientContext context;
  const auto stream = stub->StepPool(&context);
  v1::StepPoolRequest request;
  request.mutable_attach()->set_pool(CreatePool(MazeSpec(400)));
  ASSERT_TRUE(stream->Write(request));
  v1::StepPoolResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_EQ(response.attached().response_bytes_max(), 4 << 20);
  request = StepRequest(std::vector<int32_t>(400, 4));
  request.set_sequence_number(1);
  ASSERT_TRUE(stream->Write(request));
  int32_t next_environment = 0;
  for (const bool last : {false, true}) {
    ASSERT_TRUE(stream->Read(&response));
    EXPECT_LE(response.ByteSizeLong(), 4U << 20);
    EXPECT_EQ(response.sequence_number(), 1);
    EXPECT_EQ(response.batch().first_env(), next_environment);
    EXPECT_EQ(response.batch().last(), last);
    EXPECT_EQ(response.batch().rewards_size(), response.batch().env_count());
    next_environment += response.batch().env_count();
  }
  EXPECT_EQ(next_environment, 400);
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(StreamTest, SplitResponsesEqualWholeOnes) {
  procgen_client::Batch whole;
  procgen_client::Batch joined;
  const auto large_client = Connect(16 << 20);
  procgen_client::StreamOptions options;
  options.response_bytes_max = 8 << 20;
  std::vector<int32_t> actions(150);
  for (size_t i = 0; i < actions.size(); ++i) {
    actions[i] = static_cast<int32_t>(i % 16) - 1;
  }
  v1::StepPoolRequest request = StepRequest(actions);
  request.mutable_step()->set_with_final_observations(true);
  v1::Reset* reset = request.mutable_step()->add_resets();
  reset->set_environment(149);
  const auto one = large_client->Attach(CreatePool(MazeSpec(150)), options);
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT((*one)->Call(request, &whole), IsOk());
  options.response_bytes_max = 65536;
  const auto many = client_->Attach(CreatePool(MazeSpec(150)), options);
  ASSERT_THAT(many, IsOk());
  ASSERT_THAT((*many)->Call(request, &joined), IsOk());
  EXPECT_EQ(joined.env_count(), 150);
  EXPECT_EQ(joined.observations(), whole.observations());
  EXPECT_EQ(joined.final_observations(), whole.final_observations());
  EXPECT_EQ(joined.level_seeds(), whole.level_seeds());
  EXPECT_EQ(joined.first(), whole.first());
}

TEST_F(StreamTest, SequenceNumbersContinueAcrossStreams) {
  const std::string name = CreatePool(MazeSpec(1));
  procgen_client::Batch batch;
  {
    const auto stream = client_->Attach(name);
    ASSERT_THAT(stream, IsOk());
    ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
    EXPECT_THAT((*stream)->Close(), IsOk());
  }
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  EXPECT_EQ((*stream)->pool().next_sequence_number(), 2);
  ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
  EXPECT_EQ(batch.sequence_number(), 2);
  EXPECT_THAT(batch.episode_lengths(), ElementsAre(2));
}

TEST_F(StreamTest, ConcurrentLearnersAreIndependent) {
  const auto learn = [](procgen_client::StepStream* stream, std::vector<int32_t>* level_seeds) {
    procgen_client::Batch batch;
    for (int32_t i = 0; i < 200; ++i) {
      const std::vector<int32_t> actions(16, i % 10 == 9 ? -1 : i % 9);
      ASSERT_THAT(stream->Step(actions, &batch), IsOk());
      level_seeds->insert(level_seeds->end(), batch.level_seeds().begin(),
                          batch.level_seeds().end());
    }
  };
  std::vector<int32_t> first;
  std::vector<int32_t> second;
  const auto first_stream = CreateAndAttach(MazeSpec(16));
  const auto second_stream = CreateAndAttach(MazeSpec(16));
  std::thread other([&] { learn(second_stream.get(), &second); });
  learn(first_stream.get(), &first);
  other.join();
  EXPECT_EQ(first, second);
}

TEST_F(StreamTest, CancelledStreamLeavesThePoolUsable) {
  const std::string name = CreatePool(MazeSpec(64));
  const auto stub = v1::StepService::NewStub(channel_);
  {
    grpc::ClientContext context;
    const auto stream = stub->StepPool(&context);
    v1::StepPoolRequest request;
    request.mutable_attach()->set_pool(name);
    stream->Write(request);
    v1::StepPoolResponse response;
    ASSERT_TRUE(stream->Read(&response));
    for (int i = 1; i <= 2; ++i) {
      request = StepRequest(std::vector<int32_t>(64, 4));
      request.set_sequence_number(i);
      stream->Write(request);
    }
    context.TryCancel();
    while (stream->Read(&response)) {
    }
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  // The server detects the cancellation a little later, so attach is repeated.
  absl::StatusOr<std::unique_ptr<procgen_client::StepStream>> again = client_->Attach(name);
  while (again.status().code() == absl::StatusCode::kFailedPrecondition) {
    again = client_->Attach(name);
  }
  ASSERT_THAT(again, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*again)->Observe(&batch), IsOk());
  // All environments executed the same requests.
  const auto taken = static_cast<int32_t>((*again)->pool().next_sequence_number() - 1);
  EXPECT_THAT(batch.episode_lengths(), Each(taken));
}

}  // namespace
}  // namespace procgen
