#include "server/pool/pool_counts.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/pool/batch_numbers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

PoolOptions OptionsOf(std::vector<std::string> games, int32_t first_env) {
  PoolOptions options;
  options.games = std::move(games);
  options.env_count = 8;
  options.first_env = first_env;
  options.environment.distribution_mode = DistributionMode::kEasy;
  return options;
}

// The step count of `game` in the metrics.
std::string Steps(const std::string& game, int64_t count) {
  return absl::StrCat("procgen_steps_total{game=\"", game, R"(",mode="easy"} )", count, "\n");
}

std::string Episode(const std::string& what, const std::string& game, int64_t value) {
  return absl::StrCat("procgen_episode_", what, "{game=\"", game, R"(",mode="easy"} )", value,
                      "\n");
}

TEST(PoolCountsTest, StepsAreCountedByRoundRobinGame) {
  Metrics metrics("test");
  ByteBudget bytes(0);
  BatchNumbers memory;
  PoolCounts counts(OptionsOf({"maze", "heist", "ninja"}, /*first_env=*/1), &metrics, &bytes);
  // Environments 2 to 5 of the pool are 3 to 6 of the whole: maze, heist, ninja, maze.
  EXPECT_EQ(counts.Add({.first = 2, .count = 4}, memory.ReplaceEmptyArrays({}, 4), nullptr), 4);
  // Environment 0 is heist.
  EXPECT_EQ(counts.Add({.first = 0, .count = 1}, memory.ReplaceEmptyArrays({}, 1), nullptr), 1);
  EXPECT_EQ(counts.step_count(), 5);
  EXPECT_THAT(metrics.Text(), HasSubstr(Steps("maze", 2)));
  EXPECT_THAT(metrics.Text(), HasSubstr(Steps("heist", 2)));
  EXPECT_THAT(metrics.Text(), HasSubstr(Steps("ninja", 1)));
}

TEST(PoolCountsTest, ResetIsNotCountedAsAStep) {
  Metrics metrics("test");
  ByteBudget bytes(0);
  BatchNumbers memory;
  PoolCounts counts(OptionsOf({"maze", "heist"}, 0), &metrics, &bytes);
  const std::vector<Reset> resets = {{3, {}, {}}};
  EXPECT_EQ(counts.Add({.count = 8, .resets = resets}, memory.ReplaceEmptyArrays({}, 8), nullptr),
            7);
  EXPECT_THAT(metrics.Text(), HasSubstr(Steps("maze", 4)));
  EXPECT_THAT(metrics.Text(), HasSubstr(Steps("heist", 3)));
}

TEST(PoolCountsTest, EpisodesAreCountedWhenTheyEnd) {
  Metrics metrics("test");
  ByteBudget bytes(0);
  BatchNumbers memory;
  PoolCounts counts(OptionsOf({"maze", "heist"}, 0), &metrics, &bytes);
  const Batch batch = memory.ReplaceEmptyArrays({}, 4);
  std::fill(batch.terminated.begin(), batch.terminated.end(), 0);
  std::fill(batch.truncated.begin(), batch.truncated.end(), 0);
  batch.terminated[1] = 1;  // environment 3, heist
  batch.prev_level_seeds[1] = 17;
  batch.prev_level_complete[1] = 1;
  batch.fingerprints[1] = 123;
  batch.episode_returns[1] = 10;
  batch.episode_lengths[1] = 70;
  batch.truncated[2] = 1;  // environment 4, maze
  batch.episode_returns[2] = 0;
  batch.episode_lengths[2] = 500;
  counts.Add({.first = 2, .count = 4}, batch, nullptr);
  const std::string text = metrics.Text();
  EXPECT_THAT(text, HasSubstr(Episode("return_count", "heist", 1)));
  EXPECT_THAT(text, HasSubstr(Episode("return_sum", "heist", 10)));
  EXPECT_THAT(text, HasSubstr(Episode("length_steps_sum", "heist", 70)));
  EXPECT_THAT(text, HasSubstr(Episode("return_count", "maze", 1)));
  EXPECT_THAT(text, HasSubstr(Episode("length_steps_sum", "maze", 500)));
  const RecentEpisodes::Summary episodes = counts.episodes().Read();
  EXPECT_EQ(episodes.count, 2);
  EXPECT_FLOAT_EQ(episodes.mean_return, 5);
  EXPECT_FLOAT_EQ(episodes.mean_length, 285);
  const RecentEpisodes::List list = counts.episodes().ReadList(0);
  ASSERT_EQ(list.episodes.size(), 2U);
  EXPECT_EQ(list.episodes[0].environment, 3);
  EXPECT_EQ(list.episodes[0].level_seed, 17);
  EXPECT_TRUE(list.episodes[0].level_complete);
  EXPECT_FALSE(list.episodes[0].is_truncated);
  EXPECT_EQ(list.episodes[0].fingerprint, 123U);
  EXPECT_EQ(list.episodes[1].environment, 4);
  EXPECT_TRUE(list.episodes[1].is_truncated);
}

}  // namespace
}  // namespace procgen
