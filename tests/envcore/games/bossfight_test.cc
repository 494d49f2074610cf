#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kBulletKind = 1;
constexpr int kBossKind = 2;
constexpr int kBossBulletKind = 4;
constexpr int kBarrierKind = 7;

// A new level without barriers, with the ship in the lower left corner.
std::unique_ptr<Game> StagedDuel() {
  auto game = StartedGame("bossfight", 7);
  World& world = Stage(*game);
  EXPECT_EQ(world.entities[1].kind, kBossKind);
  world.entities.resize(3);  // ship, boss, shield
  world.agent().x = world.agent().rx;
  return game;
}

void AddAt(Game& game, int kind, float x, float y) {
  Stage(game).entities.push_back(Entity::Make(kind, x, y, 0, 0, 0.25F, 0.25F));
  Stage(game).entities.back().meets_entities = kind == kBulletKind || kind == kBarrierKind;
}

TEST(BossFightTest, ABarrierStopsBulletsOfBothSides) {
  const auto game = StagedDuel();
  AddAt(*game, kBarrierKind, 15, 3);
  AddAt(*game, kBossBulletKind, 15, 3);
  AddAt(*game, kBulletKind, 15, 2.9F);
  game->Play(kNoAction);
  EXPECT_EQ(CountEntities(*game, kBarrierKind), 1);
  EXPECT_EQ(CountEntities(*game, kBossBulletKind), 0);
  EXPECT_EQ(CountEntities(*game, kBulletKind), 0);
  EXPECT_EQ(CountEntities(*game, kExplosionKind), 2);
}

}  // namespace
}  // namespace procgen
