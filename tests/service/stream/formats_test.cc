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
std::vector<std::vector<uint8_t>> Expected(const v1::PoolSpec& spec,
                                           const std::vector<int32_t>& actions) {
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
  std::vector<std::vector<uint8_t>> observations;
  for (const int32_t action : actions) {
    const std::vector<int32_t> row(static_cast<size_t>(spec.env_count()), action);
    Batch batch;
    observations.emplace_back(row.size() * pool->observation_bytes());
    batch.observations = absl::MakeSpan(observations.back());
    EXPECT_THAT(pool->Step({.count = spec.env_count(), .actions = row}, batch), IsOk());
  }
  return observations;
}

class FormatsTest : public ServiceTest {
 protected:
  // Steps a pool of `spec` over gRPC and compares it with the engine.
  void ExpectEqualsTheEngine(const v1::PoolSpec& spec) {
    const std::vector<int32_t> actions = {4, 7, 7, 1, -1, 7, 3};
    const std::vector<std::vector<uint8_t>> expected = Expected(spec, actions);
    const auto stream = CreateAndAttach(spec);
    procgen_client::Batch batch;
    for (size_t i = 0; i < actions.size(); ++i) {
      const std::vector<int32_t> row(static_cast<size_t>(spec.env_count()), actions[i]);
      ASSERT_THAT(stream->Step(row, &batch), IsOk());
      ASSERT_EQ(batch.observations(), absl::MakeConstSpan(expected[i])) << i;
    }
  }
};

TEST_F(FormatsTest, PoolReturnsShapeAndBytes) {
  const auto pool =
      client_->CreatePool(FormattedSpec(1, 84, 4, v1::COLOR_GRAYSCALE, v1::LAYOUT_CHW));
  ASSERT_THAT(pool, IsOk());
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

TEST_F(FormatsTest, ChunkedObservationsEqualTheEngines) {
  ExpectEqualsTheEngine(FormattedSpec(12, 512, 1));
}

TEST_F(FormatsTest, FrameStacksContinueWithoutObservations) {
  const v1::PoolSpec spec = FormattedSpec(2, 64, 3);
  const auto expected = Expected(spec, {7, 7, 1, 7});
  const auto stream = CreateAndAttach(spec);
  procgen_client::Batch batch;
  for (const int32_t action : {7, 7, 1}) {
    v1::StepPoolRequest request = StepRequest({action, action});
    request.mutable_step()->set_observation(v1::OBSERVATION_NONE);
    ASSERT_THAT(stream->Call(request, &batch), IsOk());
    ASSERT_TRUE(batch.observations().empty());
  }
  ASSERT_THAT(stream->Step({7, 7}, &batch), IsOk());
  EXPECT_EQ(batch.observations(), absl::MakeConstSpan(expected.back()));
}

TEST_F(FormatsTest, FinalObservationsAreTheStacksOfTheEndedEpisodes) {
  v1::PoolSpec spec = FormattedSpec(3, 32, 3, v1::COLOR_GRAYSCALE);
  const auto same_step = CreateAndAttach(spec);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const auto disabled = CreateAndAttach(spec);
  procgen_client::Batch expected;
  procgen_client::Batch batch;
  ASSERT_THAT(disabled->Step({7, 7, 7}, &expected), IsOk());
  ASSERT_THAT(disabled->Step({4, -1, -1}, &expected), IsOk());
  ASSERT_THAT(same_step->Step({7, 7, 7}, &batch), IsOk());
  v1::StepPoolRequest request = StepRequest({4, -1, -1});
  request.mutable_step()->set_with_final_observations(true);
  ASSERT_THAT(same_step->Call(request, &batch), IsOk());
  EXPECT_EQ(batch.final_observations(), expected.observations().subspan(3 * 32 * 32));
}

TEST_F(FormatsTest, PoolWithObservationsBeyondAResponseIsRejected) {
  EXPECT_THAT(client_->CreatePool(FormattedSpec(1, 512, 16)), IsOk());
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.limits.response_bytes_max = 65536;
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const auto client = procgen_client::Client::Connect((*server)->address());
  ASSERT_THAT(client, IsOk());
  EXPECT_THAT((*client)->CreatePool(FormattedSpec(1, 148, 1)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "the answer for one environment has 1 x 65712 bytes of observations and "
                       "needs 66000, limit response_bytes_max is 65536"));
  EXPECT_THAT((*client)->CreatePool(FormattedSpec(1, 147, 1)), IsOk());
}

TEST_F(FormatsTest, TooSmallResponseLimitErrorNamesTheNeededSize) {
  const std::string name = CreatePool(FormattedSpec(2, 512, 6));
  const auto small = client_->Attach(name);
  ASSERT_THAT(small, IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*small)->Observe(&batch),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "the answer for one environment has 1 x 4718592 bytes of observations and "
                       "needs 4718880, limit attach.response_bytes_max is 4194304"));
  procgen_client::StreamOptions options;
  options.response_bytes_max = 4718880;
  const auto large_client = Connect(4718880);
  const auto large = large_client->Attach(name, options);
  ASSERT_THAT(large, IsOk());
  EXPECT_THAT((*large)->Observe(&batch), IsOk());
  EXPECT_EQ(batch.sequence_number(), 1) << "the rejected request took no number";
  EXPECT_EQ(batch.observations().size(), 2U * 4718592);
}

TEST_F(FormatsTest, FormatsOutOfRangeAreRejected) {
  EXPECT_THAT(client_->CreatePool(FormattedSpec(1, 15, 1)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("size_px is 15")));
  EXPECT_THAT(client_->CreatePool(FormattedSpec(1, 64, 17)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("frame_stack is 17")));
}

}  // namespace
}  // namespace procgen
