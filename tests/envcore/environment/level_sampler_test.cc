#include "envcore/environment/level_sampler.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<const LevelSampler> Made(std::vector<int32_t> level_seeds,
                                         const std::vector<float>& weights = {},
                                         int64_t rand_seed = 0) {
  return *LevelSampler::Create(std::move(level_seeds), weights, rand_seed);
}

// How often each level is drawn.
std::map<int32_t, int> Drawn(const LevelSampler& sampler, int count) {
  std::map<int32_t, int> times;
  RandomStream stream(1);
  for (int i = 0; i < count; ++i) {
    ++times[sampler.Draw(stream)];
  }
  return times;
}

TEST(LevelSamplerTest, WithoutWeightsDrawsAreUniform) {
  const std::map<int32_t, int> times = Drawn(*Made({-7, 3, 2147483647, 3}), 40000);
  EXPECT_EQ(times.size(), 3U);
  EXPECT_NEAR(times.at(-7), 10000, 500);
  EXPECT_NEAR(times.at(2147483647), 10000, 500);
  EXPECT_NEAR(times.at(3), 20000, 500) << "listed twice";
}

TEST(LevelSamplerTest, WeightsAreRelative) {
  const std::map<int32_t, int> times = Drawn(*Made({1, 2, 3, 4}, {0, 30, 10, 0}), 40000);
  EXPECT_EQ(times.size(), 2U) << "those without weight are never drawn";
  EXPECT_NEAR(times.at(2), 30000, 500);
  EXPECT_NEAR(times.at(3), 10000, 500);
}

TEST(LevelSamplerTest, ExtremeWeightsAreAccepted) {
  const float most = std::numeric_limits<float>::max();
  EXPECT_EQ(Drawn(*Made({1, 2}, {most, most}), 1000).size(), 2U);
  EXPECT_EQ(Drawn(*Made({1, 2}, {std::numeric_limits<float>::denorm_min(), 0}), 100).size(), 1U);
}

TEST(LevelSamplerTest, ADrawTakesOneOutput) {
  for (const std::vector<float>& weights : {std::vector<float>{}, std::vector<float>{1, 2}}) {
    RandomStream stream(5);
    Made({1, 2}, weights)->Draw(stream);
    EXPECT_EQ(stream.draws(), 1U);
  }
}

TEST(LevelSamplerTest, EachEnvironmentOfEachSeedHasItsOwnStream) {
  std::set<uint32_t> seeds;
  for (const int64_t rand_seed : {0, 1, 2, -1}) {
    for (int32_t environment = 0; environment < 500; ++environment) {
      seeds.insert(Made({1}, {}, rand_seed)->StreamSeedOf(environment));
    }
  }
  EXPECT_EQ(seeds.size(), 2000U);
  EXPECT_EQ(Made({1}, {}, -1)->StreamSeedOf(7), Made({2}, {}, 0xffffffff)->StreamSeedOf(7));
}

struct Wrong {
  std::vector<int32_t> level_seeds;
  std::vector<float> weights;
  std::string message;
};

TEST(LevelSamplerTest, InvalidListsAreRejectedByName) {
  const float infinite = std::numeric_limits<float>::infinity();
  const std::vector<Wrong> all = {
      {{}, {}, "level_seeds has 0 entries, must have 1 to 1000000"},
      {std::vector<int32_t>(1000001), {}, "level_seeds has 1000001 entries"},
      {{1, 2}, {1}, "weights has 1 entries, must have 2"},
      {{1, 2}, {1, -0.5F}, "weights[1] is -0.5, must be finite and at least 0"},
      {{1, 2}, {infinite, 1}, "weights[0] is inf"},
      {{1, 2}, {NAN, 1}, "weights[0] is nan"},
      {{1, 2}, {0, 0}, "weights are all 0, must have a positive sum"}};
  for (const Wrong& wrong : all) {
    EXPECT_THAT(LevelSampler::Create(wrong.level_seeds, wrong.weights, 0).status(),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(wrong.message)));
  }
}

}  // namespace
}  // namespace procgen
