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

}  // namespace
}  // namespace procgen
