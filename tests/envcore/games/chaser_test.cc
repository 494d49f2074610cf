#include <vector>

#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kLargeOrbKind = 2;
constexpr int kEggKind = 4;
constexpr int kEnemyKind = 6;

constexpr float kOrbReward = 0.04F;

// A new level without enemies, with the agent at its start.
std::unique_ptr<Game> StagedMaze() {
  auto game = StartedGame("chaser", 0);
  std::vector<Entity>& entities = Stage(*game).entities;
  entities.resize(1);
  return game;
}

void AddOnAgent(Game& game, int kind) {
  World& world = Stage(game);
  world.entities.push_back(Entity::Make(kind, world.agent().x, world.agent().y, 0, 0, 0.4F, 0.4F));
}

TEST(ChaserTest, AnEnemyKillsAndAnEggDoesNot) {
  for (const int kind : {kEnemyKind, kEggKind}) {
    const auto game = StagedMaze();
    AddOnAgent(*game, kind);
    Stage(*game).entities.back().health = 50;
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind == kEnemyKind);
    EXPECT_FALSE(game->outcome().level_complete);
  }
}

TEST(ChaserTest, EatingAnEdibleEnemyPaysNothing) {
  const auto game = StagedMaze();
  AddOnAgent(*game, kLargeOrbKind);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, kOrbReward + kOrbReward);
  AddOnAgent(*game, kEnemyKind);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_FALSE(game->outcome().done);
  EXPECT_EQ(CountEntities(*game, kEnemyKind), 0);
}

// Contacts are tested from the end of the list, and enemies are after the orbs.
TEST(ChaserTest, AnEnemyTouchedInTheStepOfTheLargeOrbStillKills) {
  const auto game = StagedMaze();
  AddOnAgent(*game, kLargeOrbKind);
  AddOnAgent(*game, kEnemyKind);
  game->Play(kNoAction);
  EXPECT_TRUE(game->outcome().done);
}

// The hatched egg remains for one more step, below its enemy.
TEST(ChaserTest, TheEggsOfANewLevelHatchInStepFifty) {
  const auto game = StartedGame("chaser", 0);
  const int egg_count = CountEntities(*game, kEggKind);
  for (int step = 1; step < 50; ++step) {
    game->Play(kNoAction);
  }
  EXPECT_EQ(CountEntities(*game, kEnemyKind), 0);
  game->Play(kNoAction);
  EXPECT_EQ(CountEntities(*game, kEnemyKind), egg_count);
  EXPECT_EQ(CountEntities(*game, kEggKind), egg_count);
  game->Play(kNoAction);
  EXPECT_EQ(CountEntities(*game, kEggKind), 0);
}

}  // namespace
}  // namespace procgen
