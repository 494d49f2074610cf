#include "envcore/environment/environment.h"

#include <limits>
#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/scripted_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int32_t kStepLimit = 5;
constexpr uint32_t kStreamSeed = 42;
constexpr int32_t kSeedMax = std::numeric_limits<int32_t>::max();

// An environment with a scripted game. Counts the calls of `before_new_level`.
class LivingEnvironment {
 public:
  explicit LivingEnvironment(const EnvironmentOptions& options = {},
                             AutoresetMode autoreset_mode = AutoresetMode::kSameStep)
      : spec_(ScriptedSpec(kStepLimit)),
        environment_(spec_, options, kStreamSeed, autoreset_mode) {}

  const StepResult& Step(int32_t action, int32_t repeat = 1) {
    environment_.Step(action, repeat, [this] {
      ++last_picture_count_;
      last_picture_seed_ = environment_.game().random().seed();
    });
    return environment_.result();
  }
  // Takes the action `count` times.
  const StepResult& StepTimes(int32_t action, int count) {
    for (int i = 0; i < count; ++i) {
      Step(action);
    }
    return environment_.result();
  }
  const StepResult& Reset(std::optional<int32_t> level_seed = std::nullopt,
                          std::optional<int64_t> rand_seed = std::nullopt) {
    environment_.Reset(level_seed, rand_seed);
    return environment_.result();
  }

  Environment& operator*() { return environment_; }
  Environment* operator->() { return &environment_; }
  const StepResult& result() const { return environment_.result(); }
  int last_picture_count() const { return last_picture_count_; }
  // The level seed of the game at the last call.
  uint32_t last_picture_seed() const { return last_picture_seed_; }

 private:
  const GameSpec spec_;
  Environment environment_;
  int last_picture_count_ = 0;
  uint32_t last_picture_seed_ = 0;
};

EnvironmentOptions Sequential() {
  EnvironmentOptions options;
  options.use_sequential_levels = true;
  return options;
}

// The level seeds drawn from the level-seed stream, in order.
class DrawnSeeds {
 public:
  explicit DrawnSeeds(int64_t stream_seed = kStreamSeed) : stream_(stream_seed) {}
  int32_t Next() { return stream_.Int(0, kSeedMax); }

 private:
  RandomStream stream_;
};

TEST(EnvironmentTest, AnEndedEpisodeIsFollowedByADrawnLevelInTheSameStep) {
  LivingEnvironment environment;
  DrawnSeeds seeds;
  const int32_t old_seed = seeds.Next();
  environment.Step(kRewardAction);
  const StepResult& result = environment.Step(kEndAction);
  EXPECT_TRUE(result.first);
  EXPECT_TRUE(result.terminated);
  EXPECT_FALSE(result.truncated);
  EXPECT_EQ(result.reward, 2);
  EXPECT_EQ(result.prev_level_seed, old_seed);
  EXPECT_EQ(result.level_seed, seeds.Next());
  EXPECT_FALSE(result.prev_level_complete);
  EXPECT_EQ(result.episode_return, 3);
  EXPECT_EQ(result.episode_length, 2);
}

TEST(EnvironmentTest, TheLastFrameCanBeDrawnBeforeTheNewLevel) {
  LivingEnvironment environment;
  const int32_t old_seed = environment.result().level_seed;
  environment.Step(kEndAction);
  EXPECT_EQ(environment.last_picture_count(), 1);
  EXPECT_EQ(environment.last_picture_seed(), static_cast<uint32_t>(old_seed));
}

// --- The step limit and the action that ends an episode.

TEST(EnvironmentTest, TheStepLimitTruncates) {
  LivingEnvironment environment;
  EXPECT_FALSE(environment.StepTimes(kNoAction, kStepLimit - 1).first);
  const StepResult& result = environment.Step(kNoAction);
  EXPECT_TRUE(result.first);
  EXPECT_TRUE(result.truncated);
  EXPECT_FALSE(result.terminated);
  EXPECT_EQ(result.episode_length, kStepLimit);
  EXPECT_EQ(environment->game().step_number(), 0);
}

// --- Sequential levels.

TEST(EnvironmentTest, AnEpisodeOfASequenceSumsRewardsOverItsLevels) {
  LivingEnvironment environment(Sequential());
  environment.Step(kCompleteAction);
  environment.Step(kRewardAction);
  const StepResult& result = environment.Step(kEndAction);
  EXPECT_EQ(result.episode_return, 4 + 1 + 2);
  EXPECT_EQ(result.episode_length, 3);
}

TEST(EnvironmentTest, InASequenceTheStepLimitHoldsForEachLevel) {
  LivingEnvironment environment(Sequential());
  environment.StepTimes(kNoAction, kStepLimit - 2);
  environment.Step(kCompleteAction);
  EXPECT_FALSE(environment.StepTimes(kNoAction, kStepLimit - 1).first);
  EXPECT_TRUE(environment.Step(kNoAction).truncated);
}

TEST(EnvironmentTest, InASequenceCompletionInTheLastStepContinues) {
  LivingEnvironment environment(Sequential());
  const int32_t old_seed = environment.result().level_seed;
  environment.StepTimes(kNoAction, kStepLimit - 1);
  const StepResult& result = environment.Step(kCompleteOnlyAction);
  EXPECT_FALSE(result.first);
  EXPECT_FALSE(result.truncated);
  EXPECT_EQ(result.level_seed, old_seed + 997);
}

TEST(EnvironmentTest, SequencesWrapAndIgnoreTheRangeOfLevels) {
  EnvironmentOptions options = Sequential();
  options.num_levels = 1;
  options.start_level = kSeedMax;
  LivingEnvironment environment(options);
  ASSERT_EQ(environment.result().level_seed, kSeedMax);
  const StepResult& result = environment.Step(kCompleteAction);
  EXPECT_EQ(result.level_seed, std::numeric_limits<int32_t>::min() + 996);
}

// --- The range of levels.

std::set<int32_t> SeedsOfManyLevels(const EnvironmentOptions& options) {
  LivingEnvironment environment(options);
  std::set<int32_t> seeds;
  for (int i = 0; i < 200; ++i) {
    seeds.insert(environment.result().level_seed);
    environment.Step(kEndAction);
  }
  return seeds;
}

TEST(EnvironmentTest, ARangePastTheLargestSeedWraps) {
  EnvironmentOptions options;
  options.start_level = kSeedMax - 1;
  options.num_levels = 4;
  const int32_t seed_min = std::numeric_limits<int32_t>::min();
  EXPECT_THAT(SeedsOfManyLevels(options),
              ElementsAre(seed_min, seed_min + 1, kSeedMax - 1, kSeedMax));
}

// --- Autoreset modes.

TEST(EnvironmentTest, WithNextStepTheEndedEpisodeStaysForAStep) {
  LivingEnvironment environment({}, AutoresetMode::kNextStep);
  const int32_t old_seed = environment.result().level_seed;
  const StepResult& ended = environment.Step(kEndAction);
  EXPECT_FALSE(ended.first);
  EXPECT_TRUE(ended.terminated);
  EXPECT_EQ(ended.reward, 2);
  EXPECT_EQ(ended.level_seed, old_seed);
  EXPECT_EQ(environment.last_picture_count(), 1);
}

TEST(EnvironmentTest, WithNextStepTheNextStepIgnoresItsActionAndBeginsALevel) {
  LivingEnvironment environment({}, AutoresetMode::kNextStep);
  DrawnSeeds seeds;
  const int32_t old_seed = seeds.Next();
  environment.Step(kEndAction);
  const StepResult& begun = environment.Step(kRewardAction, 3);
  EXPECT_TRUE(begun.first);
  EXPECT_FALSE(begun.terminated);
  EXPECT_EQ(begun.reward, 0);
  EXPECT_EQ(begun.level_seed, seeds.Next());
  EXPECT_EQ(begun.prev_level_seed, old_seed);
  EXPECT_EQ(begun.episode_length, 0);
  EXPECT_EQ(environment->game().step_number(), 0);
  EXPECT_EQ(environment.Step(kRewardAction).reward, 1);
}

TEST(EnvironmentTest, WithDisabledAnEndedEpisodeAwaitsAReset) {
  LivingEnvironment environment({}, AutoresetMode::kDisabled);
  EXPECT_FALSE(environment->awaits_reset());
  environment.Step(kEndAction);
  EXPECT_TRUE(environment->awaits_reset());
  EXPECT_TRUE(environment.result().terminated);
  EXPECT_FALSE(environment.result().first);
  EXPECT_TRUE(environment.Reset().first);
  EXPECT_FALSE(environment->awaits_reset());
}

TEST(EnvironmentTest, SequencesContinueInEveryAutoresetMode) {
  for (const AutoresetMode autoreset_mode : {AutoresetMode::kNextStep, AutoresetMode::kDisabled}) {
    LivingEnvironment environment(Sequential(), autoreset_mode);
    const int32_t old_seed = environment.result().level_seed;
    const StepResult& result = environment.Step(kCompleteAction);
    EXPECT_FALSE(result.terminated);
    EXPECT_EQ(result.level_seed, old_seed + 997);
    EXPECT_FALSE(environment->awaits_reset());
  }
}

// --- Levels that the caller chooses.

TEST(EnvironmentTest, TheNextLevelIsPlayedOnceAndTakesNoDraw) {
  LivingEnvironment environment;
  DrawnSeeds seeds;
  const int32_t old_seed = seeds.Next();
  environment->SetNextLevel(77);
  EXPECT_EQ(environment.Step(kNoAction).level_seed, old_seed);
  EXPECT_EQ(environment.Step(kEndAction).level_seed, 77);
  EXPECT_EQ(environment.Step(kEndAction).level_seed, seeds.Next());
}

TEST(EnvironmentTest, TheNextLevelReplacesTheNextOfASequence) {
  LivingEnvironment environment(Sequential());
  environment->SetNextLevel(-77);
  const StepResult& result = environment.Step(kCompleteAction);
  EXPECT_EQ(result.level_seed, -77);
  EXPECT_FALSE(result.first);
  EXPECT_EQ(environment.Step(kCompleteAction).level_seed, -77 + 997);
}

// --- Resets.

TEST(EnvironmentTest, AResetBeginsADrawnEpisodeWithoutReward) {
  LivingEnvironment environment;
  DrawnSeeds seeds;
  const int32_t old_seed = seeds.Next();
  environment.Step(kRewardAction);
  const StepResult& result = environment.Reset();
  EXPECT_TRUE(result.first);
  EXPECT_FALSE(result.terminated);
  EXPECT_FALSE(result.truncated);
  EXPECT_EQ(result.reward, 0);
  EXPECT_EQ(result.level_seed, seeds.Next());
  EXPECT_EQ(result.prev_level_seed, old_seed);
  EXPECT_EQ(result.episode_length, 0);
  EXPECT_EQ(environment.Step(kRewardAction).episode_return, 1);
}

TEST(EnvironmentTest, AResetWithARandSeedReseedsTheChoiceOfLevels) {
  LivingEnvironment environment;
  DrawnSeeds seeds(-9);
  EXPECT_EQ(environment.Reset(std::nullopt, -9).level_seed, seeds.Next());
  EXPECT_EQ(environment.Step(kEndAction).level_seed, seeds.Next());
}

TEST(EnvironmentTest, AResetWithLevelAndRandSeedPlaysTheLevelThenDraws) {
  LivingEnvironment environment;
  DrawnSeeds seeds(8);
  EXPECT_EQ(environment.Reset(5, 8).level_seed, 5);
  EXPECT_EQ(environment.Step(kEndAction).level_seed, seeds.Next());
}

// --- Repeated actions.

TEST(EnvironmentTest, ARepeatedActionSumsItsRewards) {
  LivingEnvironment environment;
  const StepResult& result = environment.Step(kRewardAction, 3);
  EXPECT_EQ(result.reward, 3);
  EXPECT_EQ(result.episode_return, 3);
  EXPECT_EQ(result.episode_length, 3);
  EXPECT_EQ(environment->game().step_number(), 3);
}

TEST(EnvironmentTest, ARepeatStopsAtTheEpisodesEnd) {
  LivingEnvironment environment;
  const StepResult& result = environment.Step(kRewardAction, 100);
  EXPECT_EQ(result.reward, kStepLimit);
  EXPECT_TRUE(result.truncated);
  EXPECT_TRUE(result.first);
  EXPECT_EQ(result.episode_length, kStepLimit);
  EXPECT_EQ(environment->game().step_number(), 0);
  EXPECT_EQ(environment.last_picture_count(), 1);
}

}  // namespace
}  // namespace procgen
