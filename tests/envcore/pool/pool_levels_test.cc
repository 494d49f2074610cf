// The levels that the environments of a pool play with a level sampler.

#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "envcore/pool/pool.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::Each;

using Levels = std::vector<std::vector<int32_t>>;  // by step, by environment

std::shared_ptr<const LevelSampler> SamplerOf(std::vector<int32_t> level_seeds,
                                              int64_t rand_seed = 0) {
  return *LevelSampler::Create(std::move(level_seeds), {}, rand_seed);
}

PoolOptions SampledOptions(std::shared_ptr<const LevelSampler> sampler) {
  PoolOptions options = OptionsOf({"maze"});
  options.level_sampler = std::move(sampler);
  return options;
}

std::vector<int32_t> LevelsNow(Pool& pool) {
  BatchBuffers buffers(pool.env_count());
  EXPECT_THAT(pool.Observe(0, pool.env_count(), buffers.Whole()), IsOk());
  return buffers.level_seeds;
}

// Ends all episodes `count` times and returns the levels that follow.
Levels EndEpisodes(Pool& pool, int count) {
  Levels levels;
  BatchBuffers buffers(pool.env_count());
  const std::vector<int32_t> ends(static_cast<size_t>(pool.env_count()), kEndEpisodeAction);
  for (int i = 0; i < count; ++i) {
    EXPECT_THAT(pool.Step({.count = pool.env_count(), .actions = ends}, buffers.Whole()), IsOk());
    levels.push_back(buffers.level_seeds);
  }
  return levels;
}

TEST(PoolLevelsTest, AllLevelsAreFromTheListIncludingTheFirst) {
  const std::unique_ptr<Pool> pool = MadePool(SampledOptions(SamplerOf({70, 71, 72})));
  EXPECT_THAT(LevelsNow(*pool), Each(::testing::AnyOf(70, 71, 72)));
  for (const std::vector<int32_t>& levels : EndEpisodes(*pool, 20)) {
    EXPECT_THAT(levels, Each(::testing::AnyOf(70, 71, 72)));
  }
}

TEST(PoolLevelsTest, EqualSamplersChooseEquallyAndOtherSeedsDoNot) {
  std::vector<int32_t> list(1000);
  std::iota(list.begin(), list.end(), 0);
  const auto levels_of = [&](int64_t rand_seed, int64_t pool_seed) {
    PoolOptions options = SampledOptions(SamplerOf(list, rand_seed));
    options.environment.rand_seed = pool_seed;
    return EndEpisodes(*MadePool(options), 10);
  };
  EXPECT_EQ(levels_of(3, 0), levels_of(3, 1)) << "the options' seed has no part in it";
  EXPECT_NE(levels_of(3, 0), levels_of(4, 0));
}

TEST(PoolLevelsTest, AShardMakesTheChoicesOfTheWholePool) {
  PoolOptions options = SampledOptions(SamplerOf({1, 2, 3, 4, 5, 6, 7, 8, 9}));
  const Levels whole = EndEpisodes(*MadePool(options), 10);
  options.first_env = 2;
  options.env_count = 2;
  options.total_env_count = kEnvCount;
  const Levels shard = EndEpisodes(*MadePool(options), 10);
  for (size_t step = 0; step < whole.size(); ++step) {
    EXPECT_EQ(shard[step], std::vector<int32_t>(whole[step].begin() + 2, whole[step].end()));
  }
}

TEST(PoolLevelsTest, AReplacedSamplerTakesEffectAtTheNextEpisode) {
  const std::unique_ptr<Pool> pool = MadePool(SampledOptions(SamplerOf({70})));
  ASSERT_THAT(pool->SetLevelSampler(SamplerOf({80})), IsOk());
  EXPECT_THAT(LevelsNow(*pool), Each(70));
  EXPECT_THAT(EndEpisodes(*pool, 2), Each(Each(80)));
}

TEST(PoolLevelsTest, AfterReplacementChoicesEqualThoseOfANewPool) {
  const auto list = SamplerOf({1, 2, 3, 4, 5, 6, 7, 8, 9}, 5);
  const std::unique_ptr<Pool> made = MadePool(SampledOptions(list));
  Levels of_new = {LevelsNow(*made)};
  for (const std::vector<int32_t>& levels : EndEpisodes(*made, 9)) {
    of_new.push_back(levels);
  }
  const std::unique_ptr<Pool> pool = MazePool();
  EndEpisodes(*pool, 3);
  ASSERT_THAT(pool->SetLevelSampler(list), IsOk());
  EXPECT_EQ(EndEpisodes(*pool, 10), of_new);
}

TEST(PoolLevelsTest, ANextLevelTakesPrecedence) {
  const std::unique_ptr<Pool> pool = MadePool(SampledOptions(SamplerOf({70})));
  BatchBuffers buffers(pool->env_count());
  const std::vector<int32_t> ends(static_cast<size_t>(pool->env_count()), kEndEpisodeAction);
  const std::vector<NextLevel> next = {{.environment = 2, .level_seed = 5}};
  ASSERT_THAT(
      pool->Step({.count = kEnvCount, .actions = ends, .next_levels = next}, buffers.Whole()),
      IsOk());
  EXPECT_THAT(buffers.level_seeds, ::testing::ElementsAre(70, 70, 5, 70));
}

TEST(PoolLevelsTest, InSequencesTheSamplerChoosesEachLevel) {
  PoolOptions options = OptionsOf({"coinrun"});
  options.environment.use_sequential_levels = true;
  options.level_sampler = SamplerOf({70, 71});
  EXPECT_THAT(EndEpisodes(*MadePool(options), 5), Each(Each(::testing::AnyOf(70, 71))));
}

TEST(PoolLevelsTest, RestoredStatesContinueTheChoicesOfTheSavedOnes) {
  const auto list = SamplerOf({1, 2, 3, 4, 5, 6, 7, 8, 9});
  const std::unique_ptr<Pool> pool = MadePool(SampledOptions(list));
  EndEpisodes(*pool, 3);
  const std::vector<int32_t> all = {0, 1, 2, 3};
  const auto snapshots = pool->SaveStates(all);
  ASSERT_THAT(snapshots.status(), IsOk());
  const std::unique_ptr<Pool> other = MadePool(SampledOptions(list));
  std::vector<StateToRestore> states;
  states.reserve(all.size());
  for (const int32_t environment : all) {
    states.push_back({environment, (*snapshots)[static_cast<size_t>(environment)]});
  }
  ASSERT_THAT(other->RestoreStates(states), IsOk());
  EXPECT_EQ(EndEpisodes(*other, 10), EndEpisodes(*pool, 10));
}

}  // namespace
}  // namespace procgen
