// Restore-then-continue equals continue, for every game in each of its modes. Environments are
// saved at some steps and restored into a running pool with other options, size and worker count.
// Then both pools continue with the same actions.

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"
#include "tests/envcore/pool/small_pool.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::HasSubstr;

constexpr int32_t kSavedCount = 3;
constexpr int32_t kOtherCount = 5;
constexpr int kStepsAfter = 40;

struct Played {
  std::string name;
  PoolOptions options;
};

// Options that change the appearance, sizes or episodes of an environment, one set per variant.
void Vary(int variant, PoolOptions* options) {
  EnvironmentOptions& environment = options->environment;
  environment.use_generated_assets = variant == 1;
  environment.use_monochrome_assets = variant == 2;
  environment.restrict_themes = variant == 2 || variant == 3;
  environment.center_agent = variant != 2;
  environment.use_sequential_levels = variant == 3;
  environment.paint_vel_info = variant == 3;
  environment.use_backgrounds = variant != 3;
  options->autoreset_mode = variant == 2 ? AutoresetMode::kNextStep : AutoresetMode::kSameStep;
}

std::vector<Played> AllThatCanBePlayed() {
  std::vector<Played> all;
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      for (int variant = 0; variant < 4; ++variant) {
        Played played = {absl::StrCat(game.name, "_", DistributionModeName(mode), "_", variant),
                         OptionsOf({std::string(game.name)}, kSavedCount)};
        played.options.environment.distribution_mode = mode;
        played.options.environment.rand_seed = 7;
        Vary(variant, &played.options);
        all.push_back(played);
      }
    }
  }
  return all;
}

std::vector<int32_t> DrawnActions(RandomStream& random, int32_t count) {
  std::vector<int32_t> actions;
  for (int32_t i = 0; i < count; ++i) {
    const int32_t action = random.Int(kActionCount);
    const bool ends = random.Int(40) == 0;
    actions.push_back(ends ? kEndEpisodeAction : action);
  }
  return actions;
}

void Play(Pool& pool, RandomStream& random, int steps) {
  BatchBuffers buffers(pool.env_count());
  for (int step = 0; step < steps; ++step) {
    const std::vector<int32_t> actions = DrawnActions(random, pool.env_count());
    ASSERT_THAT(pool.Step({.count = pool.env_count(), .actions = actions}, buffers.Whole()),
                IsOk());
  }
}

std::vector<std::string> Saved(Pool& pool, const std::vector<int32_t>& environments) {
  auto snapshots = pool.SaveStates(environments);
  EXPECT_THAT(snapshots, IsOk());
  return snapshots.ok() ? *snapshots : std::vector<std::string>(environments.size());
}

// The results of the first environments of a pool, after each of some steps.
std::vector<BatchBuffers> Continued(Pool& pool, int64_t seed) {
  RandomStream random(seed);
  std::vector<BatchBuffers> answers;
  answers.emplace_back(kSavedCount);
  EXPECT_THAT(pool.Observe(0, kSavedCount, answers.back().Whole()), IsOk());
  for (int step = 0; step < kStepsAfter; ++step) {
    const std::vector<int32_t> actions = DrawnActions(random, kSavedCount);
    answers.emplace_back(kSavedCount);
    EXPECT_THAT(pool.Step({.count = kSavedCount, .actions = actions}, answers.back().Whole()),
                IsOk());
  }
  return answers;
}

class PoolStatesTest : public ::testing::TestWithParam<Played> {};

TEST_P(PoolStatesTest, RestoredEnvironmentsContinueAsTheSavedOnes) {
  const std::unique_ptr<Pool> pool = MadePool(GetParam().options);
  PoolOptions other_options = OptionsOf(GetParam().options.games, kOtherCount);
  other_options.environment.rand_seed = 12345;
  other_options.autoreset_mode = GetParam().options.autoreset_mode;
  const std::unique_ptr<Pool> other = MadePool(other_options, /*thread_count=*/2);
  RandomStream random(5);
  RandomStream other_random(6);
  for (const int steps_between : {0, 61}) {
    Play(*pool, random, steps_between);
    Play(*other, other_random, 4);

    const std::vector<std::string> snapshots = Saved(*pool, {0, 1, 2});
    ASSERT_THAT(other->RestoreStates({{2, snapshots[2]}, {0, snapshots[0]}, {1, snapshots[1]}}),
                IsOk());

    EXPECT_EQ(Saved(*other, {0, 1, 2}), snapshots);
    EXPECT_EQ(Continued(*other, 9), Continued(*pool, 9));
    EXPECT_EQ(Saved(*other, {0, 1, 2}), Saved(*pool, {0, 1, 2}));
  }
}

INSTANTIATE_TEST_SUITE_P(EveryGame, PoolStatesTest, ::testing::ValuesIn(AllThatCanBePlayed()),
                         [](const auto& info) { return info.param.name; });

TEST(PoolSaveStatesTest, SavingChangesNothing) {
  const auto saved = MazePool();
  const auto untouched = MazePool();
  Saved(*saved, {0, 1, 2, 3});
  EXPECT_EQ(Stepped(*saved, AllTake(7)), Stepped(*untouched, AllTake(7)));
}

TEST(PoolSaveStatesTest, IndicesOutOfRangeAreRejected) {
  EXPECT_THAT(MazePool()->SaveStates({0, 4}),
              StatusIs(absl::StatusCode::kInvalidArgument, "environment 4 is not in [0, 4)"));
}

TEST(PoolRestoreStatesTest, OneInvalidSnapshotChangesNoEnvironment) {
  const auto pool = MazePool();
  std::string good = Saved(*pool, {3})[0];
  std::string bad = good;
  bad.back() = static_cast<char>(bad.back() ^ 1);
  const std::vector<std::string> before = Saved(*pool, {0, 1, 2, 3});
  EXPECT_THAT(pool->RestoreStates({{0, good}, {1, bad}}),
              StatusIs(absl::StatusCode::kDataLoss,
                       "environment 1: the snapshot's checksum does not match its body"));
  EXPECT_EQ(Saved(*pool, {0, 1, 2, 3}), before);
}

TEST(PoolRestoreStatesTest, AnEnvironmentNamedTwiceIsRejected) {
  const auto pool = MazePool();
  const std::string snapshot = Saved(*pool, {3})[0];
  EXPECT_THAT(
      pool->RestoreStates({{0, snapshot}, {0, snapshot}}),
      StatusIs(absl::StatusCode::kInvalidArgument, "environment 0 is to be restored twice"));
}

TEST(PoolRestoreStatesTest, SnapshotsOfOtherGamesAreRejected) {
  const std::string snapshot = Saved(*MazePool(), {0})[0];
  EXPECT_THAT(MadePool(OptionsOf({"miner"}))->RestoreStates({{1, snapshot}}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "environment 1: game is maze, the environment plays miner"));
}

TEST(PoolRestoreStatesTest, WithDisabledARestoredEndedEpisodeMustBeReset) {
  PoolOptions options = OptionsOf({"maze"});
  options.autoreset_mode = AutoresetMode::kNextStep;
  const auto ended = MadePool(options);
  Stepped(*ended, AllTake(kEndEpisodeAction));
  options.autoreset_mode = AutoresetMode::kDisabled;
  const auto pool = MadePool(options);
  ASSERT_THAT(pool->RestoreStates({{2, Saved(*ended, {0})[0]}}), IsOk());
  EXPECT_TRUE(pool->AwaitsReset(2));
  EXPECT_FALSE(pool->AwaitsReset(1));
  BatchBuffers buffers(kEnvCount);
  EXPECT_THAT(pool->Step({.count = kEnvCount, .actions = AllTake(4)}, buffers.Whole()),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("environment 2")));
}

TEST(PoolCloneStatesTest, StatesCanBeSwapped) {
  const auto pool = MazePool();
  const std::vector<std::string> before = Saved(*pool, {0, 1, 2, 3});
  ASSERT_THAT(pool->CloneStates({{0, 1}, {1, 0}, {0, 3}}), IsOk());
  EXPECT_THAT(Saved(*pool, {0, 1, 2, 3}),
              testing::ElementsAre(before[1], before[0], before[2], before[0]));
}

TEST(PoolCloneStatesTest, EnvironmentsOfOtherGamesAreRejected) {
  const auto pool = MadePool(OptionsOf({"maze", "miner"}));
  EXPECT_THAT(pool->CloneStates({{0, 1}}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "environment 1: game is maze, the environment plays miner"));
}

}  // namespace
}  // namespace procgen
