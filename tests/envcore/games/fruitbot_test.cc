#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kFruitBotWallKind = 1;
constexpr int kKeyKind = 3;
constexpr int kFoodKind = 4;
constexpr int kFruitKind = 7;
constexpr int kDoorKind = 10;
constexpr int kLockKind = 11;
constexpr int kPresentKind = 12;

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

TEST(FruitBotTest, WallsAndDoorsEndTheEpisodeAndLocksDoNot) {
  for (const int kind : {kFruitBotWallKind, kDoorKind, kLockKind}) {
    const auto game = StagedField();
    AddAt(*game, kind, 10, 10);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind != kLockKind) << kind;
    EXPECT_EQ(game->outcome().reward, 0);
  }
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

}  // namespace
}  // namespace procgen
