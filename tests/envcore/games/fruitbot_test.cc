#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kFruitBotWallKind = 1;
constexpr int kKeyKind = 3;
constexpr int kFoodKind = 4;
constexpr int kFruitKind = 7;
constexpr int kDoorKind = 10;
constexpr int kLockKind = 11;
constexpr int kPresentKind = 12;

constexpr int32_t kDown = 3;
constexpr int32_t kLeft = 1;
constexpr int32_t kThrow = 9;

// An empty field with the robot at (10, 10).
std::unique_ptr<Game> StagedField() {
  auto game = StartedGame("fruitbot", 0);
  StageAgentAlone(*game, 10, 10);
  return game;
}

void AddAt(Game& game, int kind, float x, float y) {
  Stage(game).entities.push_back(Entity::Make(kind, x, y, 0, 0, 0.5F, 0.3F));
}

// Adds a key at (x, y) that tests for contacts.
void AddKey(Game& game, float x, float y) {
  Stage(game).entities.push_back(Entity::Make(kKeyKind, x, y, 0, 0, 0.25F, 0.25F));
  Stage(game).entities.back().meets_entities = true;
}

TEST(FruitBotTest, DrivesUpwardWithEveryAction) {
  for (const int32_t action : {kDown, kNoAction, kThrow}) {
    const auto game = StagedField();
    game->Play(action);
    EXPECT_GT(game->world().agent().vy, 0) << action;
  }
}

TEST(FruitBotTest, TheSidesStopTheRobot) {
  const auto game = StagedField();
  Stage(*game).agent().x = 0.5F;
  for (int i = 0; i < 5; ++i) {
    game->Play(kLeft);
  }
  EXPECT_EQ(game->world().agent().x, 0.4F);
  EXPECT_FALSE(game->outcome().done);
}

TEST(FruitBotTest, FruitPaysOneAndOtherFoodCostsFour) {
  const auto game = StagedField();
  AddAt(*game, kFruitKind, 10, 10);
  AddAt(*game, kFruitKind, 10, 10);
  AddAt(*game, kFoodKind, 10, 10);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, -2);
  EXPECT_FALSE(game->outcome().done);
  EXPECT_EQ(game->world().entities.size(), 1U);
}

TEST(FruitBotTest, WallsAndDoorsEndTheEpisodeAndLocksDoNot) {
  for (const int kind : {kFruitBotWallKind, kDoorKind, kLockKind}) {
    const auto game = StagedField();
    AddAt(*game, kind, 10, 10);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind != kLockKind) << kind;
    EXPECT_EQ(game->outcome().reward, 0);
  }
}

TEST(FruitBotTest, EachTouchedPresentPaysTen) {
  const auto game = StagedField();
  AddAt(*game, kPresentKind, 9.5F, 10);
  AddAt(*game, kPresentKind, 10.5F, 10);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 20);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
}

TEST(FruitBotTest, TheFirstKeyFliesInTheEighthStepThenOneEveryEight) {
  const auto game = StagedField();
  std::vector<int> steps;
  for (int step = 1; step <= 24; ++step) {
    const int before = CountEntities(*game, kKeyKind);
    game->Play(kThrow);
    if (CountEntities(*game, kKeyKind) > before) {
      steps.push_back(step);
    }
  }
  EXPECT_THAT(steps, ElementsAre(8, 16, 24));
}

TEST(FruitBotTest, AKeyIsGoneNineStepsAfterItsThrow) {
  const auto game = StagedField();
  for (int step = 1; step <= 16; ++step) {
    game->Play(step == 8 ? kThrow : kNoAction);
  }
  EXPECT_EQ(CountEntities(*game, kKeyKind), 1);
  game->Play(kNoAction);
  EXPECT_EQ(CountEntities(*game, kKeyKind), 0);
}

TEST(FruitBotTest, AKeyOpensTheDoorBesideItsLock) {
  const auto game = StagedField();
  AddAt(*game, kDoorKind, 5, 30);
  AddAt(*game, kDoorKind, 5, 40);
  AddAt(*game, kLockKind, 6, 39.5F);
  AddKey(*game, 6, 39.5F);
  game->Play(kNoAction);
  EXPECT_EQ(CountEntities(*game, kKeyKind), 0);
  EXPECT_EQ(CountEntities(*game, kLockKind), 0);
  ASSERT_EQ(CountEntities(*game, kDoorKind), 1);
  EXPECT_EQ(game->world().entities[1].y, 30);
}

TEST(FruitBotTest, OnlyWallsStopKeys) {
  const auto game = StagedField();
  AddAt(*game, kFruitBotWallKind, 5, 30);
  AddKey(*game, 5, 30);
  for (const int kind : {kDoorKind, kFoodKind, kFruitKind, kPresentKind}) {
    AddAt(*game, kind, 5, 40);
  }
  AddKey(*game, 5, 40);
  game->Play(kNoAction);
  EXPECT_EQ(game->world().entities.size(), 1U + 1 + 4 + 1);
  EXPECT_EQ(game->world().entities.back().kind, kKeyKind);
}

TEST(FruitBotTest, TheViewIsAsWideAsTheFieldWithTheRobotNearItsLowerEdge) {
  const auto game = StagedField();
  Scene scene;
  game->FillScene(&scene);
  EXPECT_EQ(scene.camera.cells, 20);
  EXPECT_EQ(scene.camera.center_x, 10);
  EXPECT_FLOAT_EQ(scene.camera.center_y, 10 + 10 - 0.8F);
}

TEST(FruitBotTest, EveryLevelHasItsWallsAndARowOfPresents) {
  for (int32_t seed = 0; seed < 50; ++seed) {
    const auto game = StartedGame("fruitbot", seed);
    EXPECT_EQ(CountEntities(*game, kFruitBotWallKind), 2 * 10);
    EXPECT_EQ(CountEntities(*game, kPresentKind), 20);
    EXPECT_EQ(CountEntities(*game, kDoorKind), CountEntities(*game, kLockKind));
  }
}

TEST(FruitBotTest, EasyLevelsHaveNoDoors) {
  for (int32_t seed = 0; seed < 50; ++seed) {
    const auto game = StartedGame("fruitbot", seed, {.distribution_mode = DistributionMode::kEasy});
    EXPECT_EQ(CountEntities(*game, kDoorKind), 0);
  }
}

}  // namespace
}  // namespace procgen
