// Watching pools while learners step them.

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"
#include "zstd.h"

namespace procgen {
namespace {

using procgen_client::PoolWatch;
using testing::_;
using testing::HasSubstr;

constexpr size_t kAgentFrameBytes = size_t{64} * 64 * 3;

v1::WatchPoolRequest WatchRequest(const std::string& pool, const std::vector<int32_t>& environments,
                                  int32_t size_px = 64) {
  v1::WatchPoolRequest request;
  request.set_pool(pool);
  request.mutable_environments()->Add(environments.begin(), environments.end());
  request.set_size_px(size_px);
  request.set_frames_per_second_max(60);
  return request;
}

// Reads frames until the watch ends; returns its status.
absl::Status EndOf(PoolWatch* watch) {
  absl::Status status;
  while (status.ok()) {
    status = watch->Next().status();
  }
  return status;
}

// The first response after `request_count` requests.
v1::WatchPoolResponse ResponseAfter(int64_t request_count, PoolWatch* watch) {
  while (true) {
    auto response = watch->Next();
    EXPECT_THAT(response, IsOk());
    if (!response.ok() || response->request_count() >= request_count) {
      return response.value_or(v1::WatchPoolResponse());
    }
  }
}

// The same, without ends of episodes.
v1::WatchPoolResponse CurrentStatesAfter(int64_t request_count, PoolWatch* watch) {
  v1::WatchPoolResponse response = ResponseAfter(request_count, watch);
  while (std::any_of(response.frames().begin(), response.frames().end(),
                     [](const v1::Frame& frame) { return frame.has_ended_episode(); })) {
    response = ResponseAfter(request_count, watch);
  }
  return response;
}

std::string ObservationOf(const v1::Batch& batch, size_t environment) {
  return batch.observations().substr(environment * kAgentFrameBytes, kAgentFrameBytes);
}

// A step in which environment 0 ends its episode and the others do nothing.
v1::RunPoolRequest EndingStep(int32_t env_count) {
  std::vector<int32_t> actions(static_cast<size_t>(env_count), 4);
  actions[0] = -1;
  v1::RunPoolRequest request = StepRequest(actions);
  request.mutable_step()->set_with_final_observations(true);
  return request;
}

class WatchTest : public ServiceTest {};

TEST_F(WatchTest, AgentViewEqualsTheObservations) {
  const auto stream = StartPool(MazeSpec(4));
  const auto watch = client_->Watch(WatchRequest(stream->name(), {3, 0, 3}));
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  for (int32_t step = 0; step < 20; ++step) {
    ASSERT_THAT(stream->Step({step % 9, 4, 7, (step + 3) % 9}, &batch), IsOk());
    const v1::WatchPoolResponse response = CurrentStatesAfter(step + 2, watch.get());
    ASSERT_EQ(response.request_count(), step + 2);
    ASSERT_EQ(response.frames_size(), 3);
    EXPECT_EQ(response.frames(0).environment(), 3);
    EXPECT_EQ(response.frames(1).environment(), 0);
    EXPECT_EQ(response.frames(0).image(), ObservationOf(batch, 3));
    EXPECT_EQ(response.frames(1).image(), ObservationOf(batch, 0));
    EXPECT_EQ(response.frames(2).image(), response.frames(0).image());
  }
}

TEST_F(WatchTest, HumanViewEqualsRender) {
  const auto stream = StartPool(MazeSpec(2));
  const auto watch = client_->Watch(WatchRequest(stream->name(), {1}, 100));
  const auto response = watch->Next();
  ASSERT_THAT(response, IsOk());
  EXPECT_EQ(response->request_count(), 0);
  const auto rendered = stream->Render({1}, 100);
  ASSERT_THAT(rendered, IsOk());
  EXPECT_EQ(response->frames(0).image(), rendered->frames(0).image());
  EXPECT_EQ(response->frames(0).size_px(), 100);
}

TEST_F(WatchTest, BothViewsAreOfTheSameStep) {
  const auto stream = StartPool(MazeSpec(2));
  v1::WatchPoolRequest request = WatchRequest(stream->name(), {1}, 100);
  request.set_with_steps(true);
  request.set_with_agent_views(true);
  const auto watch = client_->Watch(request);
  v1::Batch batch;
  for (int32_t step = 0; step < 10; ++step) {
    ASSERT_THAT(stream->Step({4, step % 9}, &batch), IsOk());
    const v1::WatchPoolResponse response = CurrentStatesAfter(step + 1, watch.get());
    ASSERT_EQ(response.request_count(), step + 1);
    const auto human = stream->Render({1}, 100);
    ASSERT_THAT(human, IsOk());
    EXPECT_EQ(response.frames(0).image(), human->frames(0).image());
    EXPECT_EQ(response.frames(0).agent_image(), ObservationOf(batch, 1));
    EXPECT_EQ(response.frames(0).step().episode_length(), batch.episode_lengths()[1]);
  }
}

TEST_F(WatchTest, TheLastFrameOfAnEpisodeHasBothViews) {
  const auto stream = StartPool(MazeSpec(1));
  v1::WatchPoolRequest request = WatchRequest(stream->name(), {0}, 100);
  request.set_with_agent_views(true);
  const auto watch = client_->Watch(request);
  ASSERT_THAT(watch->Next(), IsOk());
  v1::Batch batch;
  ASSERT_THAT(stream->Call(EndingStep(1), &batch), IsOk());
  const v1::WatchPoolResponse response = ResponseAfter(1, watch.get());
  ASSERT_TRUE(response.frames(0).has_ended_episode());
  EXPECT_EQ(response.frames(0).agent_image(), batch.final_observations());
}

// Otherwise a pool with short episodes would never show how they run.
TEST_F(WatchTest, EveryEndIsFollowedByTheCurrentState) {
  const auto stream = StartPool(MazeSpec(1));
  const auto watch = client_->Watch(WatchRequest(stream->name(), {0}));
  ASSERT_THAT(watch->Next(), IsOk());
  bool showed_end = false;
  int end_count = 0;
  v1::Batch batch;
  for (int i = 0; i < 20; ++i) {
    ASSERT_THAT(stream->Call(EndingStep(1), &batch), IsOk());
    const auto response = watch->Next();
    ASSERT_THAT(response, IsOk());
    const bool shows_end = response->frames(0).has_ended_episode();
    EXPECT_FALSE(showed_end && shows_end) << i;
    showed_end = shows_end;
    end_count += shows_end ? 1 : 0;
  }
  EXPECT_GT(end_count, 2);
}

TEST_F(WatchTest, UnchangedFramesAreNotSent) {
  const auto stream = StartPool(MazeSpec(1));
  const auto watch = client_->Watch(WatchRequest(stream->name(), {0}));
  ASSERT_THAT(watch->Next(), IsOk());
  // A new subscriber receives the current frames at once; both then receive the next response.
  const auto second = client_->Watch(WatchRequest(stream->name(), {0}));
  ASSERT_THAT(second->Next(), IsOk());
  v1::Batch batch;
  ASSERT_THAT(stream->Step({7}, &batch), IsOk());
  for (PoolWatch* each : {watch.get(), second.get()}) {
    const auto response = each->Next();
    ASSERT_THAT(response, IsOk());
    EXPECT_EQ(response->request_count(), 1);
  }
}

TEST_F(WatchTest, NewestStepsAreReturnedOnRequest) {
  const auto stream = StartPool(MazeSpec(2));
  v1::WatchPoolRequest request = WatchRequest(stream->name(), {1, 0});
  const auto plain = client_->Watch(request);
  request.set_with_steps(true);
  const auto watch = client_->Watch(request);
  auto response = watch->Next();
  ASSERT_THAT(response, IsOk());
  ASSERT_THAT(plain->Next(), IsOk());
  EXPECT_FALSE(response->frames(0).has_step());  // nothing was stepped
  v1::Batch batch;
  ASSERT_THAT(stream->Step({7, 3}, &batch), IsOk());
  ASSERT_THAT(stream->Step({1, 5}, &batch), IsOk());
  EXPECT_FALSE(ResponseAfter(2, plain.get()).frames(0).has_step());
  v1::EnvironmentStep step = ResponseAfter(2, watch.get()).frames(0).step();
  EXPECT_EQ(step.action(), 5);
  EXPECT_EQ(step.episode_length(), 2);
  EXPECT_EQ(step.level_seed(), batch.level_seeds()[1]);

  // The end of an episode has its last step, and the start has no action.
  ASSERT_THAT(stream->Call(EndingStep(2), &batch), IsOk());
  step = ResponseAfter(3, watch.get()).frames(1).step();
  EXPECT_EQ(step.action(), -1);
  EXPECT_EQ(step.episode_length(), 3);
  EXPECT_EQ(step.level_seed(), batch.prev_level_seeds()[0]);
  response = watch->Next();
  ASSERT_THAT(response, IsOk());
  step = response->frames(1).step();
  EXPECT_FALSE(step.has_action());
  EXPECT_EQ(step.episode_length(), 0);
  EXPECT_EQ(step.level_seed(), batch.level_seeds()[0]);

  // Restored states have no known step.
  ASSERT_THAT(stream->Clone({Pair(1, 0)}), IsOk());
  response = watch->Next();
  ASSERT_THAT(response, IsOk());
  EXPECT_FALSE(response->frames(1).has_step());
}

TEST_F(WatchTest, EndsWithThePool) {
  const auto stream = StartPool(MazeSpec(1));
  const auto watch = client_->Watch(WatchRequest(stream->name(), {0}));
  ASSERT_THAT(watch->Next(), IsOk());
  ASSERT_THAT(stream->Close(), IsOk());
  EXPECT_THAT(EndOf(watch.get()), StatusIs(absl::StatusCode::kAborted,
                                           "pool " + stream->name() + " ended with its stream"));
}

TEST_F(WatchTest, EndsWhenTheServerDrains) {
  const auto stream = StartPool(MazeSpec(1));
  const auto watch = client_->Watch(WatchRequest(stream->name(), {0}));
  ASSERT_THAT(watch->Next(), IsOk());
  server_is_alive_ = false;
  server_->BeginDrain();
  EXPECT_THAT(EndOf(watch.get()), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
}

TEST_F(WatchTest, WatcherThatDoesNotReadBlocksOnlyItself) {
  const auto stream = StartPool(MazeSpec(16));
  v1::WatchPoolRequest large = WatchRequest(stream->name(), {0, 1, 2, 3}, 256);
  const auto silent = client_->Watch(large);
  const auto reader = client_->Watch(large);
  v1::Batch batch;
  for (int32_t step = 0; step < 50; ++step) {
    ASSERT_THAT(stream->Step(std::vector<int32_t>(16, step % 15), &batch), IsOk());
    EXPECT_EQ(ResponseAfter(step + 1, reader.get()).request_count(), step + 1);
  }
  ASSERT_THAT(stream->Close(), IsOk());
  EXPECT_THAT(EndOf(reader.get()), StatusIs(absl::StatusCode::kAborted, _));
  EXPECT_THAT(EndOf(silent.get()), StatusIs(absl::StatusCode::kAborted, _));
}

// A cancelled stream with a pending write must end, otherwise the server would not stop.
TEST_F(WatchTest, CancelledWatcherDelaysNothing) {
  const auto stream = StartPool(MazeSpec(16));
  const auto silent = client_->Watch(WatchRequest(stream->name(), {0, 1, 2, 3}, 256));
  v1::Batch batch;
  for (int32_t step = 0; step < 20; ++step) {
    ASSERT_THAT(stream->Step(std::vector<int32_t>(16, step % 15), &batch), IsOk());
  }
  silent->Stop();
  server_is_alive_ = false;
  server_.reset();
}

TEST_F(WatchTest, InvalidArgumentsAreRejected) {
  const auto stream = StartPool(MazeSpec(2));
  const std::string& pool = stream->name();
  const auto rejected = [&](const v1::WatchPoolRequest& request) {
    return client_->Watch(request)->Next().status();
  };
  EXPECT_THAT(rejected(WatchRequest("pools/nothing", {0})),
              StatusIs(absl::StatusCode::kNotFound, _));
  EXPECT_THAT(rejected(WatchRequest(pool, {})),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("environments is empty")));
  EXPECT_THAT(rejected(WatchRequest(pool, {2})),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("environments[0] is 2")));
  EXPECT_THAT(rejected(WatchRequest(pool, std::vector<int32_t>(65, 0))),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "environments has 65 entries, allowed: 1 to 64"));
  EXPECT_THAT(rejected(WatchRequest(pool, {0}, 15)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("size_px is 15")));
  v1::WatchPoolRequest request = WatchRequest(pool, {0});
  for (const float rate : {-1.0F, 61.0F, std::numeric_limits<float>::quiet_NaN()}) {
    request.set_frames_per_second_max(rate);
    EXPECT_THAT(rejected(request),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: above 0 to 60")));
  }
  EXPECT_THAT(rejected(WatchRequest(pool, std::vector<int32_t>(64, 0), 512)),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("16777216")));
}

TEST_F(WatchTest, DeltasDecodeToTheRawImages) {
  const auto stream = StartPool(MazeSpec(3));
  v1::WatchPoolRequest request = WatchRequest(stream->name(), {2, 0});
  const auto raw = client_->Watch(request);
  request.set_encoding(v1::ENCODING_DELTA_ZSTD);
  request.set_with_steps(true);
  const auto encoded = client_->Watch(request);
  std::string images(2 * kAgentFrameBytes, '\0');
  v1::Batch batch;
  size_t encoded_bytes = 0;
  for (int32_t step = 0; step < 10; ++step) {
    ASSERT_THAT(stream->Step({7, 4, step % 9}, &batch), IsOk());
    int64_t request_count = 0;
    while (request_count < step + 1) {
      const auto response = encoded->Next();
      ASSERT_THAT(response, IsOk());
      request_count = response->request_count();
      ASSERT_EQ(response->frames_size(), 2);
      EXPECT_EQ(response->frames(0).environment(), 2);
      EXPECT_EQ(response->frames(0).image(), "");
      encoded_bytes += response->encoded_images().size();
      std::string differences(images.size(), '\0');
      ASSERT_EQ(
          ZSTD_decompress(differences.data(), differences.size(), response->encoded_images().data(),
                          response->encoded_images().size()),
          images.size());
      for (size_t i = 0; i < images.size(); ++i) {
        images[i] = static_cast<char>(images[i] + differences[i]);
      }
    }
    const v1::WatchPoolResponse expected = ResponseAfter(step + 1, raw.get());
    EXPECT_EQ(images.substr(0, kAgentFrameBytes), expected.frames(0).image());
    EXPECT_EQ(images.substr(kAgentFrameBytes), expected.frames(1).image());
  }
  EXPECT_LT(encoded_bytes, 10 * kAgentFrameBytes);
}

TEST_F(WatchTest, EncodingsAndFormatsThatDoNotFitAreRejected) {
  const auto stream = StartPool(MazeSpec(1));
  v1::WatchPoolRequest request = WatchRequest(stream->name(), {0});
  request.set_format(v1::FRAME_FORMAT_NONE);
  EXPECT_THAT(client_->Watch(request)->Next(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed in a watch")));
  request.set_format(v1::FRAME_FORMAT_PNG);
  request.set_encoding(v1::ENCODING_DELTA_ZSTD);
  EXPECT_THAT(client_->Watch(request)->Next(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("allowed with ENCODING_DELTA_ZSTD: FRAME_FORMAT_RGB")));
  request.set_encoding(v1::ENCODING_RAW);
  request.set_with_agent_views(true);
  EXPECT_THAT(client_->Watch(request)->Next(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "with_agent_views is true with size_px 64 and encoding ENCODING_RAW, "
                       "allowed: a size_px other than 64, and ENCODING_RAW"));
  request.set_with_agent_views(false);
  request.set_encoding(static_cast<v1::Encoding>(3));
  EXPECT_THAT(client_->Watch(request)->Next(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("encoding is number 3")));
}

}  // namespace
}  // namespace procgen
