#include "server/dm_env_rpc/world_settings.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/dm_env_rpc/test_session.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Settings SettingsOf(const SettingList& list) { return {list.begin(), list.end()}; }

absl::StatusOr<WorldOptions> ReadOptions(SettingList list) {
  list.try_emplace("env_name", TextTensor("maze"));
  return ReadWorldSettings(SettingsOf(list), Limits());
}

TEST(WorldSettingsTest, DefaultsAreThoseOfUpstream) {
  const auto options = ReadOptions({});
  ASSERT_THAT(options, IsOk());
  EXPECT_THAT(options->pool_options.games, ElementsAre("maze"));
  EXPECT_EQ(options->pool_options.env_count, 1);
  EXPECT_EQ(options->pool_options.autoreset_mode, AutoresetMode::kDisabled);
  const EnvironmentOptions defaults;
  EXPECT_EQ(options->pool_options.environment.distribution_mode, DistributionMode::kHard);
  EXPECT_EQ(options->pool_options.environment.center_agent, defaults.center_agent);
  EXPECT_EQ(options->pool_options.environment.use_backgrounds, defaults.use_backgrounds);
  EXPECT_EQ(options->session_options.lease_duration, Limits().lease_duration_default);
}

TEST(WorldSettingsTest, EverySettingIsApplied) {
  const auto options = ReadOptions({{"num_envs", IntegerTensor(3)},
                                    {"distribution_mode", IntegerTensor(10)},
                                    {"num_levels", IntegerTensor(4)},
                                    {"start_level", IntegerTensor(5)},
                                    {"rand_seed", IntegerTensor(-6)},
                                    {"use_sequential_levels", IntegerTensor(1)},
                                    {"center_agent", IntegerTensor(0)},
                                    {"use_backgrounds", IntegerTensor(0)},
                                    {"use_generated_assets", IntegerTensor(1)},
                                    {"use_monochrome_assets", IntegerTensor(1)},
                                    {"restrict_themes", IntegerTensor(1)},
                                    {"paint_vel_info", IntegerTensor(1)},
                                    {"debug_mode", IntegerTensor(14)},
                                    {"screen_size", IntegerTensor(84)},
                                    {"grayscale_obs", IntegerTensor(1)},
                                    {"layout", TextTensor("chw")},
                                    {"frame_stack", IntegerTensor(4)},
                                    {"first_env", IntegerTensor(2)},
                                    {"total_env_count", IntegerTensor(9)},
                                    {"lease_duration", IntegerTensor(60)},
                                    {"pool_id", TextTensor("mine")}});
  ASSERT_THAT(options, IsOk());
  const EnvironmentOptions& environment = options->pool_options.environment;
  EXPECT_EQ(options->pool_options.env_count, 3);
  EXPECT_EQ(options->pool_options.autoreset_mode, AutoresetMode::kSameStep);
  EXPECT_EQ(environment.distribution_mode, DistributionMode::kMemory);
  EXPECT_EQ(environment.num_levels, 4);
  EXPECT_EQ(environment.start_level, 5);
  EXPECT_EQ(environment.rand_seed, -6);
  EXPECT_TRUE(environment.use_sequential_levels);
  EXPECT_FALSE(environment.center_agent);
  EXPECT_FALSE(environment.use_backgrounds);
  EXPECT_TRUE(environment.use_generated_assets);
  EXPECT_TRUE(environment.use_monochrome_assets);
  EXPECT_TRUE(environment.restrict_themes);
  EXPECT_TRUE(environment.paint_vel_info);
  EXPECT_EQ(environment.debug_mode, 14);
  EXPECT_THAT(options->pool_options.observation_format.Shape(), ElementsAre(4, 1, 84, 84));
  EXPECT_EQ(options->pool_options.first_env, 2);
  EXPECT_EQ(options->pool_options.total_env_count, 9);
  EXPECT_EQ(options->session_options.lease_duration, absl::Minutes(1));
  EXPECT_EQ(options->pool_id, "mine");
}

TEST(WorldSettingsTest, ShardMustLieWithinThePool) {
  EXPECT_THAT(ReadOptions({{"first_env", IntegerTensor(4)}, {"total_env_count", IntegerTensor(4)}}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("total_env_count is 4, allowed: first_env + num_envs = 5")));
}

TEST(WorldSettingsTest, LongTextIsNotEchoed) {
  const auto options = ReadOptions({{std::string(1 << 20, 'x'), IntegerTensor(1)}});
  EXPECT_LT(options.status().message().size(), 600U);
  const auto game = ReadOptions({{"env_name", TextTensor(std::string(1 << 20, 'x'))}});
  EXPECT_LT(game.status().message().size(), 200U);
}

TEST(EpisodeSettingsTest, ScalarIsBroadcastToAllLevelsAndCountsUpForSeeds) {
  const auto read = ReadEpisodeSettings(
      SettingsOf({{"level_seed", IntegerTensor(8)}, {"rand_seed", IntegerTensor(INT64_MAX)}}),
      TensorShape::List(2));
  ASSERT_THAT(read, IsOk());
  EXPECT_THAT(read->level_seeds, ElementsAre(8, 8));
  EXPECT_THAT(read->rand_seeds, ElementsAre(INT64_MAX, INT64_MIN));
}

TEST(EpisodeSettingsTest, ALevelSeedHas32Bits) {
  EXPECT_THAT(ReadEpisodeSettings(SettingsOf({{"level_seed", IntegerTensor(int64_t{1} << 31)}}),
                                  TensorShape::Scalar()),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("level_seed is 2147483648")));
}

}  // namespace
}  // namespace procgen
