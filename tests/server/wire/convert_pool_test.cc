#include "server/wire/convert_pool.h"

#include <string>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

v1::PoolSpec MazeSpec() {
  v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(4);
  return spec;
}

TEST(ConvertPoolTest, UnsetOptionsHaveThePythonPackagesDefaults) {
  const absl::StatusOr<PoolOptions> options = PoolOptionsOf(MazeSpec());
  ASSERT_THAT(options, IsOk());
  EXPECT_EQ(options->environment.distribution_mode, DistributionMode::kHard);
  EXPECT_TRUE(options->environment.center_agent);
  EXPECT_TRUE(options->environment.use_backgrounds);
  EXPECT_EQ(options->autoreset_mode, AutoresetMode::kSameStep);
  EXPECT_GE(options->environment.rand_seed, 0);
  EXPECT_LT(options->environment.rand_seed, 2147483647);
}

TEST(ConvertPoolTest, FalseDiffersFromUnset) {
  v1::PoolSpec spec = MazeSpec();
  spec.mutable_options()->set_center_agent(false);
  spec.mutable_options()->set_rand_seed(0);
  const absl::StatusOr<PoolOptions> options = PoolOptionsOf(spec);
  ASSERT_THAT(options, IsOk());
  EXPECT_FALSE(options->environment.center_agent);
  EXPECT_EQ(options->environment.rand_seed, 0);
}

TEST(ConvertPoolTest, EmptyGamesAreRejected) {
  EXPECT_THAT(
      PoolOptionsOf(v1::PoolSpec()),
      StatusIs(absl::StatusCode::kInvalidArgument, "spec.games has 0 entries, allowed: 1 to 64"));
}

TEST(ConvertPoolTest, UnknownModeNumberIsRejected) {
  v1::PoolSpec spec = MazeSpec();
  spec.mutable_options()->set_distribution_mode(static_cast<v1::DistributionMode>(99));
  EXPECT_THAT(PoolOptionsOf(spec),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("distribution_mode is number 99, allowed: "
                                 "DISTRIBUTION_MODE_EASY, DISTRIBUTION_MODE_HARD")));
}

TEST(ConvertPoolTest, AVariantIsReadAndReturnedAndAnUnknownOneIsRejected) {
  v1::PoolSpec spec = MazeSpec();
  EXPECT_EQ(PoolOptionsOf(spec)->environment.variant, Variant::kNone);
  spec.mutable_options()->set_variant("cheese_corner");
  const absl::StatusOr<PoolOptions> options = PoolOptionsOf(spec);
  ASSERT_THAT(options, IsOk());
  EXPECT_EQ(options->environment.variant, Variant::kCheeseCorner);
  EXPECT_EQ(PoolSpecMessageOf(*options).options().variant(), "cheese_corner");
  spec.mutable_options()->set_variant("cheese");
  EXPECT_THAT(PoolOptionsOf(spec),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("spec.options.variant is cheese, must be one of coin_random "
                                 "(coinrun), cheese_corner (maze), two_objects (maze), ")));
  spec.mutable_options()->set_variant("gravity=0.1");
  spec.set_games(0, "coinrun");
  const absl::StatusOr<PoolOptions> with_value = PoolOptionsOf(spec);
  ASSERT_THAT(with_value, IsOk());
  EXPECT_EQ(with_value->environment.variant_value, 0.1F);
  EXPECT_EQ(PoolSpecMessageOf(*with_value).options().variant(), "gravity=0.1");
}

TEST(ConvertPoolTest, ShardBeyondThePoolIsRejected) {
  v1::PoolSpec spec = MazeSpec();
  spec.set_first_env(10);
  spec.set_total_env_count(13);
  EXPECT_THAT(PoolOptionsOf(spec), StatusIs(absl::StatusCode::kInvalidArgument,
                                            HasSubstr("spec.total_env_count is 13, allowed: 0, or "
                                                      "first_env + env_count = 14")));
  spec.set_total_env_count(14);
  EXPECT_THAT(PoolOptionsOf(spec), IsOk());
  spec.set_first_env(INT32_MAX);
  spec.set_total_env_count(0);
  EXPECT_THAT(PoolOptionsOf(spec), StatusIs(absl::StatusCode::kInvalidArgument, testing::_));
}

TEST(ConvertPoolTest, UnsetObservationFormatIsUpstreams) {
  EXPECT_EQ(PoolOptionsOf(MazeSpec())->observation_format, ObservationFormat());
  v1::PoolSpec spec = MazeSpec();
  spec.mutable_observation_format();
  EXPECT_EQ(PoolOptionsOf(spec)->observation_format, ObservationFormat());
}

TEST(ConvertPoolTest, ObservationFormatIsConverted) {
  v1::PoolSpec spec = MazeSpec();
  v1::ObservationFormat* format = spec.mutable_observation_format();
  format->set_color(v1::COLOR_GRAYSCALE);
  format->set_layout(v1::LAYOUT_CHW);
  format->set_size_px(84);
  format->set_frame_stack(4);
  ObservationFormat expected;
  expected.frame = {.size_px = 84, .color = Color::kGrayscale, .layout = Layout::kChw};
  expected.frame_stack = 4;
  EXPECT_EQ(PoolOptionsOf(spec)->observation_format, expected);
}

TEST(ConvertPoolTest, ObservationFormatsOutOfRangeAreRejected) {
  const auto message = [](const auto& set) {
    v1::PoolSpec spec = MazeSpec();
    set(spec.mutable_observation_format());
    const absl::Status status = PoolOptionsOf(spec).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  using Format = v1::ObservationFormat*;
  EXPECT_EQ(message([](Format format) { format->set_size_px(15); }),
            "spec.observation_format.size_px is 15, allowed: 0, or 16 to 512");
  EXPECT_EQ(message([](Format format) { format->set_size_px(513); }),
            "spec.observation_format.size_px is 513, allowed: 0, or 16 to 512");
  EXPECT_EQ(message([](Format format) { format->set_size_px(-1); }),
            "spec.observation_format.size_px is -1, allowed: 0, or 16 to 512");
  EXPECT_EQ(message([](Format format) { format->set_frame_stack(17); }),
            "spec.observation_format.frame_stack is 17, allowed: 0 to 16");
  EXPECT_EQ(message([](Format format) { format->set_frame_stack(-1); }),
            "spec.observation_format.frame_stack is -1, allowed: 0 to 16");
  EXPECT_EQ(message([](Format format) { format->set_color(static_cast<v1::Color>(9)); }),
            "spec.observation_format.color is number 9, allowed: COLOR_RGB, COLOR_GRAYSCALE");
  EXPECT_EQ(message([](Format format) { format->set_layout(static_cast<v1::Layout>(9)); }),
            "spec.observation_format.layout is number 9, allowed: LAYOUT_HWC, LAYOUT_CHW");
}

TEST(ConvertPoolTest, LevelSamplersAreConvertedAndErrorsNameFields) {
  v1::PoolSpec spec = MazeSpec();
  EXPECT_EQ(PoolOptionsOf(spec)->level_sampler, nullptr);
  spec.mutable_level_sampler()->add_level_seeds(7);
  spec.mutable_level_sampler()->add_level_seeds(-9);
  spec.mutable_level_sampler()->add_weights(0);
  EXPECT_THAT(PoolOptionsOf(spec),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "spec.level_sampler.weights has 1 entries, must have 2, as level_seeds, or "
                       "none"));
  spec.mutable_level_sampler()->add_weights(0.5F);
  const auto options = PoolOptionsOf(spec);
  ASSERT_THAT(options, IsOk());
  RandomStream stream(1);
  EXPECT_EQ(options->level_sampler->Draw(stream), -9);
}

}  // namespace
}  // namespace procgen
