#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kBulletKind = 1;
constexpr int kFlyerBulletKind = 2;
constexpr int kFlyerKind = 4;
constexpr int kCloudKind = 6;
constexpr int kTurretKind = 7;

// An empty sky with the ship at (4, 8).
std::unique_ptr<Game> StagedSky() {
  auto game = StartedGame("starpilot", 0);
  StageAgentAlone(*game, 4, 8);
  return game;
}

Entity& AddAt(Game& game, int kind, float x, float y) {
  Entity& entity = Stage(game).entities.emplace_back(Entity::Make(kind, x, y, 0, 0, 0.5F, 0.5F));
  entity.meets_entities = kind == kBulletKind;
  return entity;
}

TEST(StarPilotTest, EnemiesAndTheirBulletsKillAndCloudsDoNot) {
  for (const int kind : {kFlyerKind, kFlyerBulletKind, kTurretKind, kCloudKind}) {
    const auto game = StagedSky();
    AddAt(*game, kind, 4, 8);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind != kCloudKind) << kind;
    EXPECT_FALSE(game->outcome().level_complete);
  }
}

TEST(StarPilotTest, AnEnemyPaysWhenDestroyedAndStaysForAStep) {
  const auto game = StagedSky();
  AddAt(*game, kFlyerKind, 12, 12).health = 2;
  for (const float reward : {0.0F, 1.0F}) {
    AddAt(*game, kBulletKind, 12, 12);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().reward, reward);
    EXPECT_EQ(CountEntities(*game, kFlyerKind), 1);
    EXPECT_EQ(CountEntities(*game, kBulletKind), 0);
  }
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_EQ(CountEntities(*game, kFlyerKind), 0);
}

TEST(StarPilotTest, ADestroyedEnemyStillKillsInItsLastStep) {
  const auto game = StagedSky();
  AddAt(*game, kFlyerKind, 12, 12).health = 1;
  AddAt(*game, kBulletKind, 12, 12);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 1);
  Stage(*game).agent().x = 12;
  Stage(*game).agent().y = 12;
  game->Play(kNoAction);
  EXPECT_TRUE(game->outcome().done);
}

}  // namespace
}  // namespace procgen
