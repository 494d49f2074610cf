// Levels of a learner's environments: requested one by one, or chosen by a level sampler.

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::AnyOf;
using testing::Each;
using testing::ElementsAre;

v1::LevelSampler SamplerOf(const std::vector<int32_t>& level_seeds, int64_t rand_seed = 0) {
  v1::LevelSampler sampler;
  sampler.mutable_level_seeds()->Add(level_seeds.begin(), level_seeds.end());
  sampler.set_rand_seed(rand_seed);
  return sampler;
}

v1::RunPoolRequest SamplerRequest(const std::vector<int32_t>& level_seeds) {
  v1::RunPoolRequest request;
  *request.mutable_level_sampler() = SamplerOf(level_seeds);
  return request;
}

v1::PoolSpec SampledSpec(int32_t env_count, const v1::LevelSampler& sampler) {
  v1::PoolSpec spec = MazeSpec(env_count);
  *spec.mutable_level_sampler() = sampler;
  return spec;
}

class LevelsTest : public ServiceTest {
 protected:
  // Ends the episodes of a pool of three environments; returns the new levels.
  static std::vector<int32_t> EndEpisodes(PoolStream* stream) {
    v1::Batch batch;
    EXPECT_THAT(stream->Step({-1, -1, -1}, &batch), IsOk());
    return {batch.level_seeds().begin(), batch.level_seeds().end()};
  }
};

TEST_F(LevelsTest, SamplerChoosesTheFirstLevelToo) {
  const auto stream = StartPool(SampledSpec(3, SamplerOf({70, 71})));
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_THAT(batch.level_seeds(), Each(AnyOf(70, 71))) << "known before the first action";
  for (int i = 0; i < 5; ++i) {
    EXPECT_THAT(EndEpisodes(stream.get()), Each(AnyOf(70, 71)));
  }
}

TEST_F(LevelsTest, ReplacedSamplerTakesEffectAtTheNextEpisode) {
  const auto stream = StartPool(MazeSpec(3));
  v1::Batch before;
  ASSERT_THAT(stream->Observe(&before), IsOk());
  ASSERT_THAT(stream->Call(SamplerRequest({-5})), IsOk());
  v1::Batch after;
  ASSERT_THAT(stream->Observe(&after), IsOk());
  EXPECT_THAT(after.level_seeds(), testing::ElementsAreArray(before.level_seeds()));
  EXPECT_THAT(EndEpisodes(stream.get()), Each(-5));
  ASSERT_THAT(stream->Call(SamplerRequest({6})), IsOk());
  EXPECT_THAT(EndEpisodes(stream.get()), Each(6));
}

TEST_F(LevelsTest, EqualSamplersChooseAlikeOnEveryPool) {
  const v1::LevelSampler sampler = SamplerOf({1, 2, 3, 4, 5, 6, 7, 8, 9}, 11);
  const auto one = StartPool(SampledSpec(3, sampler));
  const auto other = StartPool(SampledSpec(3, sampler));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(EndEpisodes(one.get()), EndEpisodes(other.get()));
  }
}

TEST_F(LevelsTest, NextLevelOverridesTheSampler) {
  const auto stream = StartPool(SampledSpec(3, SamplerOf({70})));
  v1::RunPoolRequest request = StepRequest({-1, -1, -1});
  v1::NextLevel* next = request.mutable_step()->add_next_levels();
  next->set_environment(1);
  next->set_level_seed(-8);
  v1::Batch batch;
  ASSERT_THAT(stream->Call(request, &batch), IsOk());
  EXPECT_THAT(batch.level_seeds(), ElementsAre(70, -8, 70));
}

TEST_F(LevelsTest, SamplerSentAheadIsAnsweredInOrder) {
  const auto stream = StartPool(MazeSpec(3));
  stream->Write(SamplerRequest({70}));
  stream->Write(StepRequest({-1, -1, -1}));
  EXPECT_TRUE(stream->Read()->has_ack());
  v1::Batch batch;
  ASSERT_THAT(stream->Read(&batch), IsOk());
  EXPECT_THAT(batch.level_seeds(), Each(70));
}

TEST_F(LevelsTest, PoolOmitsTheSampler) {
  EXPECT_FALSE(StartPool(SampledSpec(3, SamplerOf({70})))->pool().spec().has_level_sampler());
}

}  // namespace
}  // namespace procgen
