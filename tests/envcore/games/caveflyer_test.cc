#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kMeteorKind = 2;
constexpr int kSaucerKind = 3;
constexpr int kShotKind = 4;
constexpr int kEnemyShipKind = 5;

// An empty cave with the ship at (20, 20), facing up.
std::unique_ptr<Game> StagedCave() {
  auto game = StartedGame("caveflyer", 0);
  StageAgentAlone(*game, 20, 20);
  Stage(*game).agent().rotation = 0;
  return game;
}

Entity& AddAt(Game& game, int kind, float x, float y) {
  Entity& entity = Stage(game).entities.emplace_back(Entity::Make(kind, x, y, 0, 0, 0.5F, 0.5F));
  entity.meets_entities = kind != kShotKind;
  return entity;
}

TEST(CaveFlyerTest, MeteorsSaucersAndEnemyShipsKill) {
  for (const int kind : {kMeteorKind, kSaucerKind, kEnemyShipKind, kShotKind}) {
    const auto game = StagedCave();
    AddAt(*game, kind, 20, 20);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind != kShotKind) << kind;
    EXPECT_EQ(game->outcome().reward, 0);
  }
}

TEST(CaveFlyerTest, ASaucerPaysThreeWhenDestroyedAndAMeteorNever) {
  const auto game = StagedCave();
  AddAt(*game, kSaucerKind, 10, 10).health = 2;
  AddAt(*game, kMeteorKind, 30, 10);
  for (const float reward : {0.0F, 3.0F}) {
    AddAt(*game, kShotKind, 10, 10);
    AddAt(*game, kShotKind, 30, 10);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().reward, reward);
    EXPECT_EQ(CountEntities(*game, kShotKind), 0);
  }
  EXPECT_EQ(CountEntities(*game, kSaucerKind), 0);
  EXPECT_EQ(CountEntities(*game, kMeteorKind), 1);
}

}  // namespace
}  // namespace procgen
