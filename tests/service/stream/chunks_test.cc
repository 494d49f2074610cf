// A chunked step equals a whole one, bit for bit. It is accepted or rejected as a whole.

#include <cstdint>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"

namespace procgen {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

v1::PoolSpec SpecOf(const std::string& game, int32_t env_count) {
  v1::PoolSpec spec = MazeSpec(env_count);
  spec.set_games(0, game);
  return spec;
}

// Actions, ends of episodes, next levels and resets, spread over the pool.
v1::StepPoolRequest RequestAt(int step, int32_t env_count) {
  std::vector<int32_t> actions(static_cast<size_t>(env_count));
  for (int32_t i = 0; i < env_count; ++i) {
    actions[static_cast<size_t>(i)] = (step / 3 * 5 + i * 7) % 16 - 1;
  }
  v1::StepPoolRequest request = StepRequest(actions);
  v1::Step* message = request.mutable_step();
  message->set_with_final_observations(step % 2 == 0);
  message->set_observation(step % 5 == 4 ? v1::OBSERVATION_NONE : v1::OBSERVATION_FRAME);
  for (int32_t i = step % 3; i < env_count; i += 3) {
    v1::NextLevel* next = message->add_next_levels();
    next->set_environment(i);
    next->set_level_seed(100 * step + i);
  }
  for (int32_t i = env_count - 1 - step; i >= 0; i -= 11) {
    message->add_resets()->set_environment(i);
  }
  return request;
}

class ChunksTest : public ServiceTest {
 protected:
  // Steps a pool; returns the number of environments in each response.
  std::vector<int32_t> ResponseSizes(int32_t env_count, int32_t chunk_count) {
    const std::string name = CreatePool(MazeSpec(env_count));
    const auto stub = v1::StepService::NewStub(channel_);
    grpc::ClientContext context;
    const auto stream = stub->StepPool(&context);
    v1::StepPoolRequest request;
    request.mutable_attach()->set_pool(name);
    stream->Write(request);
    request = StepRequest(std::vector<int32_t>(static_cast<size_t>(env_count), 4));
    request.set_sequence_number(1);
    request.mutable_step()->set_chunk_count(chunk_count);
    stream->Write(request);
    stream->WritesDone();
    v1::StepPoolResponse response;
    EXPECT_TRUE(stream->Read(&response));
    std::vector<int32_t> sizes;
    int32_t next = 0;
    while (stream->Read(&response)) {
      EXPECT_EQ(response.sequence_number(), 1);
      EXPECT_EQ(response.batch().first_env(), next);
      EXPECT_EQ(response.batch().rewards_size(), response.batch().env_count());
      sizes.push_back(response.batch().env_count());
      next += sizes.back();
      EXPECT_EQ(response.batch().last(), next == env_count);
    }
    EXPECT_TRUE(stream->Finish().ok());
    EXPECT_THAT(client_->DeletePool(name), IsOk());
    return sizes;
  }

  // Compares chunked steps of one pool with whole steps of another.
  void ExpectChunkedStepsEqualWholeOnes(const v1::PoolSpec& spec) {
    const auto whole = CreateAndAttach(spec);
    const auto chunked = CreateAndAttach(spec);
    procgen_client::Batch expected;
    procgen_client::Batch batch;
    for (int step = 0; step < 12; ++step) {
      v1::StepPoolRequest request = RequestAt(step, spec.env_count());
      ASSERT_THAT(whole->Call(request, &expected), IsOk());
      request.mutable_step()->set_chunk_count(2 + step % 5);
      ASSERT_THAT(chunked->Call(request, &batch), IsOk());
      ASSERT_TRUE(BatchCopy(batch) == BatchCopy(expected)) << "step " << step;
    }
    EXPECT_THAT(client_->DeletePool(whole->pool().name()), IsOk());
    EXPECT_THAT(client_->DeletePool(chunked->pool().name()), IsOk());
  }
};

TEST_F(ChunksTest, StepIsSplitIntoTheRequestedChunks) {
  EXPECT_THAT(ResponseSizes(8, 0), ElementsAre(8));
  EXPECT_THAT(ResponseSizes(8, 1), ElementsAre(8));
  EXPECT_THAT(ResponseSizes(8, 2), ElementsAre(4, 4));
  EXPECT_THAT(ResponseSizes(5, 4), ElementsAre(2, 1, 1, 1));
  EXPECT_THAT(ResponseSizes(3, 64), ElementsAre(1, 1, 1));
}

TEST_F(ChunksTest, ResponsesStayWithinTheirLimit) {
  // Five environments fit 65536 bytes.
  procgen_client::StreamOptions options;
  options.response_bytes_max = 65536;
  options.chunk_count = 2;
  const auto stream = CreateAndAttach(MazeSpec(33), options);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step(std::vector<int32_t>(33, 4), &batch), IsOk());
  EXPECT_EQ(batch.env_count(), 33);
  EXPECT_THAT(batch.episode_lengths(), Each(1));
}

TEST_F(ChunksTest, ChunkedStepsEqualWholeOnes) {
  for (const std::string game : {"bigfish", "coinrun", "maze", "plunder"}) {
    for (const int32_t env_count : {1, 2, 13, 40}) {
      SCOPED_TRACE(game + ", environments: " + std::to_string(env_count));
      ExpectChunkedStepsEqualWholeOnes(SpecOf(game, env_count));
    }
  }
}

TEST_F(ChunksTest, ClientUsesTheConfiguredChunkCount) {
  procgen_client::StreamOptions options;
  options.chunk_count = 3;
  const auto chunked = CreateAndAttach(MazeSpec(10), options);
  options.chunk_count = 1;
  const auto whole = CreateAndAttach(MazeSpec(10), options);
  EXPECT_EQ(chunked->chunk_count(), 3);
  procgen_client::Batch expected;
  procgen_client::Batch batch;
  for (int step = 0; step < 20; ++step) {
    std::vector<int32_t> actions(10, step % 9);
    actions[static_cast<size_t>(step % 10)] = -1;
    ASSERT_THAT(whole->Step(actions, &expected), IsOk());
    ASSERT_THAT(chunked->SendStep(actions), IsOk());
    ASSERT_THAT(chunked->Receive(&batch), IsOk());
    ASSERT_TRUE(BatchCopy(batch) == BatchCopy(expected)) << step;
  }
}

TEST_F(ChunksTest, OnlyLargePoolsAreChunkedByDefault) {
  EXPECT_EQ(CreateAndAttach(MazeSpec(16))->chunk_count(), 1);
  EXPECT_GT(CreateAndAttach(MazeSpec(400))->chunk_count(), 1);
}

TEST_F(ChunksTest, ErrorInTheLastChunkStepsNothing) {
  const std::string name = CreatePool(MazeSpec(8));
  procgen_client::StreamOptions options;
  options.chunk_count = 4;
  std::vector<int32_t> wrong(8, 4);
  wrong.back() = 15;
  procgen_client::Batch batch;
  {
    const auto stream = client_->Attach(name, options);
    ASSERT_THAT(stream, IsOk());
    EXPECT_THAT((*stream)->Step(wrong, &batch),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("actions[7] is 15")));
  }
  const auto stream = client_->Attach(name, options);
  ASSERT_THAT(stream, IsOk());
  EXPECT_EQ((*stream)->pool().next_sequence_number(), 1);
  ASSERT_THAT((*stream)->Step(std::vector<int32_t>(8, 4), &batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), Each(1));
}

TEST_F(ChunksTest, MissingResetInTheLastChunkStepsNothing) {
  v1::PoolSpec spec = MazeSpec(4);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const std::string name = CreatePool(spec);
  procgen_client::StreamOptions options;
  options.chunk_count = 2;
  procgen_client::Batch batch;
  {
    const auto stream = client_->Attach(name, options);
    ASSERT_THAT(stream, IsOk());
    ASSERT_THAT((*stream)->Step({4, 4, 4, -1}, &batch), IsOk());
    EXPECT_THAT((*stream)->Step({4, 4, 4, 4}, &batch),
                StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("environment 3")));
  }
  const auto stream = client_->Attach(name, options);
  ASSERT_THAT(stream, IsOk());
  ASSERT_THAT((*stream)->Observe(&batch), IsOk());
  EXPECT_THAT(batch.episode_lengths(), Each(1));
}

}  // namespace
}  // namespace procgen
