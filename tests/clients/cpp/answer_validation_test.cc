#include "procgen_client/internal/answer_validation.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using procgen_client::ValidateEpisode;
using procgen_client::ValidateFrames;
using procgen_client::ValidateStates;
using testing::HasSubstr;

v1::RenderEnvironmentsResponse Frames(const std::vector<int32_t>& environments, int32_t size_px) {
  v1::RenderEnvironmentsResponse response;
  for (const int32_t environment : environments) {
    v1::Frame* frame = response.add_frames();
    frame->set_environment(environment);
    frame->set_size_px(size_px);
    frame->set_image(
        std::string(static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3, 'i'));
  }
  return response;
}

v1::SaveStatesResponse States(const std::vector<int32_t>& environments,
                              const std::string& next_page_token = "") {
  v1::SaveStatesResponse page;
  for (const int32_t environment : environments) {
    v1::State* state = page.add_states();
    state->set_environment(environment);
    state->set_snapshot("snapshot");
  }
  page.set_next_page_token(next_page_token);
  return page;
}

v1::Episode Episode() {
  v1::Episode episode;
  episode.set_environment(2);
  episode.set_actions("\1\2\3");
  episode.mutable_rewards()->Resize(2, 0);
  episode.add_action_counts(1);
  episode.add_action_counts(2);
  episode.add_level_changes()->set_action(2);
  return episode;
}

absl::Status StatusFor(const v1::RenderEnvironmentsResponse& response,
                       v1::FrameFormat format = v1::FRAME_FORMAT_RGB) {
  return ValidateFrames(response.frames(), {4, 2}, 16, format);
}

auto IsWrong(const std::string& message) {
  return StatusIs(absl::StatusCode::kInternal, HasSubstr(message));
}

TEST(AnswerValidationTest, FramesMatchTheRequest) {
  EXPECT_THAT(StatusFor(Frames({4, 2}, 16)), IsOk());
  EXPECT_THAT(StatusFor({}), IsWrong("0 frames, expected: 2"));
  EXPECT_THAT(StatusFor(Frames({4, 2, 2}, 16)), IsWrong("3 frames, expected: 2"));
  EXPECT_THAT(StatusFor(Frames({4, 3}, 16)), IsWrong("a frame of environment 3, expected: 2"));
  EXPECT_THAT(StatusFor(Frames({4, 2}, 17)), IsWrong("17 x 17 pixels, expected: a square of 16"));
  EXPECT_THAT(StatusFor(Frames({4, 2}, 16), v1::FRAME_FORMAT_PNG), IsWrong("expected: a PNG file"));
  v1::RenderEnvironmentsResponse frames = Frames({4, 2}, 16);
  frames.mutable_frames(1)->mutable_image()->resize(10);
  EXPECT_THAT(StatusFor(frames), IsWrong("a frame in 10 bytes, expected: 768"));
  frames.mutable_frames(1)->set_size_px(INT32_MAX);
  EXPECT_THAT(StatusFor(frames), IsWrong("a frame of 2147483647 x 2147483647 pixels"));
}

TEST(AnswerValidationTest, FramesOfAnySizeAreSquares) {
  const v1::RenderEnvironmentsResponse frames = Frames({0}, 512);
  EXPECT_THAT(ValidateFrames(frames.frames(), {0}, 0, v1::FRAME_FORMAT_RGB), IsOk());
  EXPECT_THAT(ValidateFrames(Frames({0}, 0).frames(), {0}, 0, v1::FRAME_FORMAT_RGB),
              IsWrong("a frame of 0 x 0 pixels, expected: a square of 1 to 2048"));
}

TEST(AnswerValidationTest, StatesMatchTheRequestPageByPage) {
  EXPECT_THAT(ValidateStates(States({3, 1}), {3, 1}, 0), IsOk());
  EXPECT_THAT(ValidateStates(States({3}, "more"), {3, 1}, 0), IsOk());
  EXPECT_THAT(ValidateStates(States({1}), {3, 1}, 1), IsOk());
  EXPECT_THAT(ValidateStates(States({3}), {3, 1}, 0), IsWrong("1 states after 0, expected: 2"));
  EXPECT_THAT(ValidateStates(States({}), {3, 1}, 0), IsWrong("0 states after 0, expected: 2"));
  EXPECT_THAT(ValidateStates(States({1, 3}), {3, 1}, 0), IsWrong("environment 1, expected: 3"));
  EXPECT_THAT(ValidateStates(States({3, 1, 1}), {3, 1}, 0), IsWrong("3 states after 0"));
}

TEST(AnswerValidationTest, PagesAfterTheLastStateAreRejected) {
  EXPECT_THAT(ValidateStates(States({3, 1}, "more"), {3, 1}, 0), IsWrong("and more to come"));
  EXPECT_THAT(ValidateStates(States({}, "more"), {}, 2), IsWrong("0 states after 2"));
  EXPECT_THAT(ValidateStates(States({2, 3}, "more"), {}, 2), IsOk());
  EXPECT_THAT(ValidateStates(States({0, 1}, "more"), {}, 2),
              IsWrong("a state of environment 0, expected: 2"));
}

TEST(AnswerValidationTest, SnapshotSizesAreBounded) {
  v1::SaveStatesResponse page = States({0});
  page.mutable_states(0)->clear_snapshot();
  EXPECT_THAT(ValidateStates(page, {0}, 0), IsWrong("a snapshot of 0 bytes"));
  page.mutable_states(0)->set_snapshot(std::string((1 << 20) + 1, 's'));
  EXPECT_THAT(ValidateStates(page, {0}, 0), IsWrong("a snapshot of 1048577 bytes"));
}

TEST(AnswerValidationTest, InconsistentEpisodesAreRejected) {
  EXPECT_THAT(ValidateEpisode(Episode(), 2), IsOk());
  EXPECT_THAT(ValidateEpisode(Episode(), 1), IsWrong("environment 2, expected: 1"));
  v1::Episode episode = Episode();
  episode.mutable_level_changes(0)->set_action(3);
  EXPECT_THAT(ValidateEpisode(episode, 2), IsWrong("begins with action 3, expected: one of 3"));
  episode = Episode();
  episode.set_action_counts(1, INT32_MAX);
  EXPECT_THAT(ValidateEpisode(episode, 2), IsWrong("with 2147483648 actions"));
  episode = Episode();
  episode.clear_rewards();
  EXPECT_THAT(ValidateEpisode(episode, 2), IsWrong("0 rewards of 2 steps"));
}

TEST(AnswerValidationTest, CreatedPoolMatchesTheRequest) {
  v1::CreatePoolRequest request;
  request.set_pool_id("a");
  request.mutable_spec()->set_env_count(4);
  v1::Pool pool;
  pool.set_name("pools/a");
  pool.mutable_spec()->set_env_count(4);
  pool.add_observation_shape(3);
  pool.set_observation_bytes(3);
  EXPECT_THAT(procgen_client::ValidateCreatedPool(pool, request), IsOk());
  pool.mutable_spec()->set_env_count(5);
  EXPECT_THAT(procgen_client::ValidateCreatedPool(pool, request),
              IsWrong("a pool of 5 environments, expected: 4"));
  pool.set_name("pools/b");
  EXPECT_THAT(procgen_client::ValidateCreatedPool(pool, request),
              IsWrong("pool 'pools/b', expected: 'pools/a'"));
}

}  // namespace
}  // namespace procgen
