// Observation formats over gRPC: observations equal those of the engine in the pool's format. The
// engine's tests check the pixels.

#include <memory>
#include <string>
#include <vector>

#include "envcore/pool/pool.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::PoolSpec FormattedSpec(int32_t env_count, int32_t size_px, int32_t frame_stack,
                           v1::Color color = v1::COLOR_RGB, v1::Layout layout = v1::LAYOUT_HWC) {
  v1::PoolSpec spec = MazeSpec(env_count);
  v1::ObservationFormat* format = spec.mutable_observation_format();
  format->set_color(color);
  format->set_layout(layout);
  format->set_size_px(size_px);
  format->set_frame_stack(frame_stack);
  return spec;
}

// The observations of an engine pool of the same spec after each of `actions`.
std::vector<std::string> Expected(const v1::PoolSpec& spec, const std::vector<int32_t>& actions) {
  PoolOptions options;
  options.games = {spec.games(0)};
  options.env_count = spec.env_count();
  options.environment.distribution_mode = DistributionMode::kEasy;
  options.environment.rand_seed = spec.options().rand_seed();
  const v1::ObservationFormat& format = spec.observation_format();
  options.observation_format.frame = {
      .size_px = format.size_px(),
      .color = format.color() == v1::COLOR_RGB ? Color::kRgb : Color::kGrayscale,
      .layout = format.layout() == v1::LAYOUT_HWC ? Layout::kHwc : Layout::kChw};
  options.observation_format.frame_stack = format.frame_stack();
  const auto pool = *Pool::Create(options, std::make_shared<WorkerPool>(0));
  std::vector<std::string> observations;
  for (const int32_t action : actions) {
    const std::vector<int32_t> row(static_cast<size_t>(spec.env_count()), action);
    Batch batch;
    std::string& bytes = observations.emplace_back(row.size() * pool->observation_bytes(), '\0');
    batch.observations = absl::MakeSpan(reinterpret_cast<uint8_t*>(bytes.data()), bytes.size());
    EXPECT_THAT(pool->Step({.count = spec.env_count(), .actions = row}, batch), IsOk());
  }
  return observations;
}

class FormatsTest : public ServiceTest {
 protected:
  // Steps a pool of `spec` over gRPC and compares it with the engine.
  void ExpectEqualsTheEngine(const v1::PoolSpec& spec) {
    const std::vector<int32_t> actions = {4, 7, 7, 1, -1, 7, 3};
    const std::vector<std::string> expected = Expected(spec, actions);
    const auto stream = StartPool(spec);
    v1::Batch batch;
    for (size_t i = 0; i < actions.size(); ++i) {
      const std::vector<int32_t> row(static_cast<size_t>(spec.env_count()), actions[i]);
      ASSERT_THAT(stream->Step(row, &batch), IsOk());
      ASSERT_TRUE(batch.observations() == expected[i]) << i;
    }
  }
};

TEST_F(FormatsTest, PoolReturnsShapeAndBytes) {
  const auto stream = StartPool(FormattedSpec(1, 84, 4, v1::COLOR_GRAYSCALE, v1::LAYOUT_CHW));
  const v1::Pool* pool = &stream->pool();
  EXPECT_THAT(pool->observation_shape(), ElementsAre(4, 1, 84, 84));
  EXPECT_EQ(pool->observation_bytes(), 28224);
  EXPECT_EQ(pool->spec().observation_format().color(), v1::COLOR_GRAYSCALE);
  EXPECT_EQ(pool->spec().observation_format().layout(), v1::LAYOUT_CHW);
  EXPECT_EQ(pool->spec().observation_format().size_px(), 84);
  EXPECT_EQ(pool->spec().observation_format().frame_stack(), 4);
}

TEST_F(FormatsTest, ObservationsEqualTheEngines) {
  ExpectEqualsTheEngine(FormattedSpec(3, 84, 4, v1::COLOR_GRAYSCALE));
  ExpectEqualsTheEngine(FormattedSpec(3, 16, 1, v1::COLOR_RGB, v1::LAYOUT_CHW));
  ExpectEqualsTheEngine(FormattedSpec(2, 512, 2));
}

TEST_F(FormatsTest, LargeObservationsEqualTheEngines) {
  ExpectEqualsTheEngine(FormattedSpec(12, 512, 1));
}

TEST_F(FormatsTest, FrameStacksContinueWithoutObservations) {
  const v1::PoolSpec spec = FormattedSpec(2, 64, 3);
  const auto expected = Expected(spec, {7, 7, 1, 7});
  const auto stream = StartPool(spec);
  v1::Batch batch;
  for (const int32_t action : {7, 7, 1}) {
    v1::RunPoolRequest request = StepRequest({action, action});
    request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
    ASSERT_THAT(stream->Call(request, &batch), IsOk());
    ASSERT_TRUE(batch.observations().empty());
  }
  ASSERT_THAT(stream->Step({7, 7}, &batch), IsOk());
  EXPECT_TRUE(batch.observations() == expected.back());
}

TEST_F(FormatsTest, FinalObservationsAreTheStacksOfTheEndedEpisodes) {
  v1::PoolSpec spec = FormattedSpec(3, 32, 3, v1::COLOR_GRAYSCALE);
  const auto same_step = StartPool(spec);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto disabled = StartPool(spec);
  v1::Batch expected;
  v1::Batch batch;
  ASSERT_THAT(disabled->Step({7, 7, 7}, &expected), IsOk());
  ASSERT_THAT(disabled->Step({4, -1, -1}, &expected), IsOk());
  ASSERT_THAT(same_step->Step({7, 7, 7}, &batch), IsOk());
  v1::RunPoolRequest request = StepRequest({4, -1, -1});
  request.mutable_step()->set_with_final_observations(true);
  ASSERT_THAT(same_step->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.final_observations(), expected.observations().substr(3 * 32 * 32));
}

TEST_F(FormatsTest, ObservationsBeyondAResponseAreRejected) {
  Limits limits = TestLimits();
  limits.response_bytes_max = 65536;
  const auto small = StartServer(/*worker_count=*/1, limits);
  ASSERT_NE(small, nullptr);
  const auto channel = ChannelTo(small->address());
  EXPECT_THAT(PoolStream(channel).Start(FormattedSpec(1, 148, 1)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "slice.env_count is 1, limit response_bytes_max is 65536, which has room "
                       "for 0 environments of 65712 bytes"));
  v1::Batch batch;
  PoolStream run(channel);
  ASSERT_THAT(run.Start(FormattedSpec(6, 64, 1)), IsOk());
  ASSERT_THAT(run.Call(ObserveRequest(5), &batch), IsOk());
  EXPECT_LE(batch.ByteSizeLong(), 65536U);
  EXPECT_THAT(run.Observe(&batch),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "slice.env_count is 6, limit response_bytes_max is 65536, which has room "
                       "for 5 environments of 12288 bytes"));
}

TEST_F(FormatsTest, FormatsOutOfRangeAreRejected) {
  EXPECT_THAT(StartError(FormattedSpec(1, 15, 1)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("size_px is 15")));
  EXPECT_THAT(StartError(FormattedSpec(1, 64, 17)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("frame_stack is 17")));
}

}  // namespace
}  // namespace procgen
