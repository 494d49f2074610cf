#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kBulletKind = 1;
constexpr int kBossKind = 2;
constexpr int kBossBulletKind = 4;
constexpr int kReflectedKind = 6;
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

// Level 7 has three rounds of seven hits; in hard mode its shield drops in step 21 * (5 + 1).
TEST(BossFightTest, ARoundPaysOneAndRaisesTheShieldAgain) {
  const auto game = StagedDuel();
  for (int step = 1; step <= 126; ++step) {
    game->Play(kNoAction);
    Stage(*game).entities.resize(3);
  }
  for (int hit = 1; hit <= 7; ++hit) {
    EXPECT_EQ(game->outcome().reward, 0) << hit;
    Stage(*game).entities.resize(3);
    AddAt(*game, kBulletKind, game->world().entities[1].x, game->world().entities[1].y);
    game->Play(kNoAction);
  }
  EXPECT_EQ(game->outcome().reward, 1);
  EXPECT_FALSE(game->outcome().done);
  EXPECT_EQ(game->world().entities[1].health, 14);
  AddAt(*game, kBulletKind, game->world().entities[1].x, game->world().entities[1].y);
  game->Play(kNoAction);
  EXPECT_EQ(game->world().entities[1].health, 14);
  EXPECT_EQ(CountEntities(*game, kReflectedKind), 1);
}

TEST(BossFightTest, BulletsBarriersAndTheBossKill) {
  for (const int kind : {kBossBulletKind, kBarrierKind, kBossKind, kBulletKind}) {
    const auto game = StagedDuel();
    AddAt(*game, kind, game->world().agent().x, game->world().agent().y);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind != kBulletKind) << kind;
    EXPECT_EQ(game->outcome().reward, 0);
  }
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
