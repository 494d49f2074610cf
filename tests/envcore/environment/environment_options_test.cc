#include "envcore/environment/environment_options.h"

#include <limits>
#include <string>

#include "absl/status/status.h"
#include "envcore/games/game_catalog.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

EnvironmentOptions OptionsWith(DistributionMode mode) {
  EnvironmentOptions options;
  options.distribution_mode = mode;
  return options;
}

void ExpectInvalid(const std::string& game, const EnvironmentOptions& options,
                   const std::string& message) {
  const absl::Status status = ResolveOptions(game, options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), message);
}

TEST(ResolveOptionsTest, DefaultsAreThoseOfUpstream) {
  const EnvironmentOptions options;
  EXPECT_EQ(options.distribution_mode, DistributionMode::kHard);
  EXPECT_EQ(options.num_levels, 0);
  EXPECT_EQ(options.start_level, 0);
  EXPECT_TRUE(options.center_agent);
  EXPECT_TRUE(options.use_backgrounds);
  EXPECT_FALSE(options.use_sequential_levels);
  EXPECT_FALSE(options.use_generated_assets);
  EXPECT_FALSE(options.use_monochrome_assets);
  EXPECT_FALSE(options.restrict_themes);
  EXPECT_FALSE(options.paint_vel_info);
  EXPECT_EQ(options.debug_mode, 0);
  EXPECT_TRUE(ResolveOptions("maze", options).ok());
}

TEST(ResolveOptionsTest, UnknownGamesAreNotFoundAndTheErrorListsTheGames) {
  const absl::Status status = ResolveOptions("pacman", {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no game is named \"pacman\"; there are "));
  EXPECT_THAT(std::string(status.message()), HasSubstr("bigfish, "));
}

TEST(RequireVariantTest, AnUnknownNameIsRejectedAndTheErrorListsAllWithTheirGames) {
  EnvironmentOptions options;
  EXPECT_TRUE(RequireVariant("two_objects", &options).ok());
  EXPECT_EQ(options.variant, Variant::kTwoObjects);
  const Status status = RequireVariant("coins", &options);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("variant is coins, must be one of coin_random (coinrun), "
                        "cheese_corner (maze), two_objects (maze), gravity=0.2 (climber), "));
}

TEST(ResolveOptionsTest, AValueOutOfRangeIsRejectedAndTheErrorHasTheRange) {
  EnvironmentOptions options;
  options.variant = Variant::kGravity;
  for (const float value : {0.05F, 0.2F, 0.8F}) {
    options.variant_value = value;
    EXPECT_TRUE(ResolveOptions("coinrun", options).ok());
  }
  for (const float value : {0.0F, 0.04F, 0.9F, std::numeric_limits<float>::quiet_NaN()}) {
    options.variant_value = value;
    EXPECT_FALSE(ResolveOptions("coinrun", options).ok()) << value;
  }
  options.variant_value = 5;
  ExpectInvalid("coinrun", options, "variant is gravity=5, the value of coinrun is in [0.05, 0.8]");
  ExpectInvalid("dodgeball", options, "variant is gravity=5, dodgeball has enemy_speed=0.05");
  options.variant = Variant::kNone;
  EXPECT_FALSE(ResolveOptions("coinrun", options).ok());
}

TEST(ResolveOptionsTest, AVariantOfAnotherGameIsRejectedAndTheErrorListsTheVariants) {
  EnvironmentOptions options;
  options.variant = Variant::kCoinRandom;
  EXPECT_TRUE(ResolveOptions("coinrun", options).ok());
  ExpectInvalid("maze", options, "variant is coin_random, maze has cheese_corner, two_objects");
  ExpectInvalid("bigfish", options, "variant is coin_random, bigfish has no variants");
}

TEST(ResolveOptionsTest, AnUnsupportedModeIsRejectedAndTheErrorListsTheModes) {
  ExpectInvalid("coinrun", OptionsWith(DistributionMode::kMemory),
                "distribution_mode is memory (10), coinrun has easy, hard, exploration");
  ExpectInvalid("miner", OptionsWith(DistributionMode::kExtreme),
                "distribution_mode is extreme (2), miner has easy, hard, memory");
  ExpectInvalid("bigfish", OptionsWith(DistributionMode::kExploration),
                "distribution_mode is exploration (20), bigfish has easy, hard");
  ExpectInvalid("bigfish", OptionsWith(static_cast<DistributionMode>(7)),
                "distribution_mode is unknown (7), bigfish has easy, hard");
}

TEST(ResolveOptionsTest, NegativeLevelsAreRejected) {
  EnvironmentOptions options;
  options.num_levels = -1;
  ExpectInvalid("maze", options, "num_levels is -1, must be at least 0");
  options = {};
  options.start_level = -3;
  ExpectInvalid("maze", options, "start_level is -3, must be at least 0");
}

TEST(ResolveOptionsTest, TheLargestLevelsAreAccepted) {
  EnvironmentOptions options;
  options.num_levels = std::numeric_limits<int32_t>::max();
  options.start_level = std::numeric_limits<int32_t>::max();
  options.rand_seed = std::numeric_limits<int64_t>::min();
  EXPECT_TRUE(ResolveOptions("maze", options).ok());
}

TEST(ResolveOptionsTest, ExplorationIsOneHardLevelOfTheGame) {
  const auto resolved = ResolveOptions("maze", OptionsWith(DistributionMode::kExploration));
  ASSERT_TRUE(resolved.ok());
  EXPECT_EQ(resolved->distribution_mode, DistributionMode::kHard);
  EXPECT_EQ(resolved->num_levels, 1);
  EXPECT_EQ(resolved->start_level, 158988835);
}

TEST(ResolveOptionsTest, ExplorationRejectsNumLevelsAndStartLevel) {
  EnvironmentOptions options = OptionsWith(DistributionMode::kExploration);
  options.num_levels = 5;
  options.start_level = 6;
  ExpectInvalid("maze", options,
                "distribution_mode exploration plays one level of its own: num_levels and "
                "start_level must be 0, are 5 and 6");
}

}  // namespace
}  // namespace procgen
