#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kFishKind = 2;

// A hard level with only the agent (half-size 0.5) in the middle.
std::unique_ptr<Game> QuietTank() {
  auto game = StartedGame("bigfish", 0);
  StageAgentAlone(*game, 10, 10);
  return game;
}

// Adds a fish at rest on the agent.
void AddFish(Game& game, float radius) {
  Stage(game).entities.push_back(Entity::Make(kFishKind, 10, 10, 0, 0, radius, radius));
}

// Ignores fish that entered at the edges.
int FishInTheMiddle(const Game& game) {
  int count = 0;
  for (const Entity& entity : game.world().entities) {
    count += entity.kind == kFishKind && entity.x == 10 ? 1 : 0;
  }
  return count;
}

TEST(BigFishTest, AgentStartsAboveTheGroundAtTheSizeOfItsMode) {
  const auto easy = StartedGame("bigfish", 0, {.distribution_mode = DistributionMode::kEasy});
  const auto hard = StartedGame("bigfish", 0);
  EXPECT_EQ(easy->world().agent().rx, 1);
  EXPECT_EQ(easy->world().agent().y, 2);
  EXPECT_EQ(hard->world().agent().rx, 0.5F);
  EXPECT_EQ(hard->world().agent().y, 1.5F);
}

TEST(BigFishTest, EatsAFishThatIsJustAsWide) {
  const auto game = QuietTank();
  AddFish(*game, 0.5F);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 1);
  EXPECT_FALSE(game->outcome().done);
  EXPECT_EQ(FishInTheMiddle(*game), 0);
  EXPECT_EQ(game->world().agent().rx, 0.5F + 0.0500000007F);
  EXPECT_EQ(game->world().agent().ry, 0.5F + 0.0500000007F);
}

TEST(BigFishTest, AWiderFishEndsTheEpisodeAndStays) {
  const auto game = QuietTank();
  AddFish(*game, 0.500001F);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_FALSE(game->outcome().level_complete);
  EXPECT_EQ(FishInTheMiddle(*game), 1);
}

TEST(BigFishTest, OnlyWidthsAreCompared) {
  const auto game = QuietTank();
  AddFish(*game, 0.5F);
  Stage(*game).entities.back().ry = 3;
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 1);
}

TEST(BigFishTest, GrowthCountsForFishThatAreMetLaterInTheSameStep) {
  const auto game = QuietTank();
  AddFish(*game, 0.52F);
  AddFish(*game, 0.5F);  // met first
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 2);
  EXPECT_FALSE(game->outcome().done);
}

TEST(BigFishTest, FishAreEatenAfterAWiderOneInTheSameStep) {
  const auto game = QuietTank();
  AddFish(*game, 0.5F);
  AddFish(*game, 0.52F);  // met first
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 1);
  EXPECT_TRUE(game->outcome().done);
}

TEST(BigFishTest, ThirtyFishCompleteTheLevelEvenWithAWiderOne) {
  const auto game = QuietTank();
  AddFish(*game, 9);
  for (int i = 0; i < 30; ++i) {
    AddFish(*game, 0.25F);
  }
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 40);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
  EXPECT_NEAR(game->world().agent().rx, 2, 1e-5);
}

TEST(BigFishTest, TwentyNineFishDoNotCompleteTheLevel) {
  const auto game = QuietTank();
  for (int i = 0; i < 29; ++i) {
    AddFish(*game, 0.25F);
  }
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 29);
  EXPECT_FALSE(game->outcome().done);
}

TEST(BigFishTest, TheAgentFacesWhereItSteers) {
  const auto game = QuietTank();
  std::vector<bool> mirrored;
  for (const int32_t action : {0, 4, 5, 7, 3, 1}) {
    game->Play(action);
    mirrored.push_back(game->world().agent().mirrored);
  }
  EXPECT_THAT(mirrored, ElementsAre(true, true, true, false, false, true));
}

TEST(BigFishTest, TheWholeTankIsInViewWithAndWithoutCenterAgent) {
  const auto game = StartedGame("bigfish", 0, {.center_agent = true});
  Scene scene;
  game->FillScene(&scene);
  EXPECT_EQ(scene.camera.cells, 20);
  EXPECT_EQ(scene.camera.center_x, 10);
}

struct SpawnedFish {
  int32_t step;
  float x, y, vx, rx, ry;
  int theme;
};

// Values given by the specification.
TEST(BigFishTest, LevelSevenHasTheFishOfTheSpecification) {
  const std::vector<SpawnedFish> expected = {
      {3, 20.9856873F, 4.75722837F, -0.17168586F, 0.985687554F, 0.529350698F, 2},
      {11, -1.29946744F, 3.71313262F, 0.263031006F, 1.29946744F, 0.766352594F, 0},
      {14, -1.87904835F, 13.8266439F, 0.193513185F, 1.87904835F, 1.47639513F, 1},
      {26, 20.8159733F, 14.1185579F, -0.228498667F, 0.81597358F, 0.641122103F, 1}};
  const auto game = StartedGame("bigfish", 7);
  EXPECT_EQ(game->world().agent().x, 15.3744411F);
  size_t fish_count = 0;
  for (int32_t step = 1; step <= 26; ++step) {
    game->Play(kNoAction);
    Stage(*game).agent().rx = 0;  // touches nothing
    if (game->world().entities.size() > 1 + fish_count) {
      ASSERT_LT(fish_count, expected.size());
      const SpawnedFish& fish = expected[fish_count++];
      const Entity& entity = game->world().entities.back();
      EXPECT_EQ(step, fish.step);
      EXPECT_EQ(entity.x, fish.x);
      EXPECT_EQ(entity.y, fish.y);
      EXPECT_EQ(entity.vx, fish.vx);
      EXPECT_EQ(entity.rx, fish.rx);
      EXPECT_EQ(entity.ry, fish.ry);
      EXPECT_EQ(entity.theme, fish.theme);
      EXPECT_EQ(entity.mirrored, fish.vx < 0);
    }
  }
  EXPECT_EQ(fish_count, expected.size());
}

TEST(BigFishTest, RestrictedThemesHaveTheSizeOfTheFirstImage) {
  const auto game = StartedGame("bigfish", 7, {.restrict_themes = true});
  for (int i = 0; i < 3; ++i) {
    game->Play(kNoAction);
  }
  const Entity& fish = game->world().entities.back();
  EXPECT_EQ(fish.theme, 2) << "the draw is stored as it was";
  EXPECT_EQ(fish.ry, fish.rx / static_cast<float>(78.0 / 46.0));
  Scene scene;
  game->FillScene(&scene);
  EXPECT_EQ(scene.above_cells.front().theme, 0);
}

}  // namespace
}  // namespace procgen
