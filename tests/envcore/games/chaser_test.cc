#include <vector>

#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kLargeOrbKind = 2;
constexpr int kEnemyKind = 6;

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

// Contacts are tested from the end of the list, and enemies are after the orbs.
TEST(ChaserTest, AnEnemyTouchedInTheStepOfTheLargeOrbStillKills) {
  const auto game = StagedMaze();
  AddOnAgent(*game, kLargeOrbKind);
  AddOnAgent(*game, kEnemyKind);
  game->Play(kNoAction);
  EXPECT_TRUE(game->outcome().done);
}

}  // namespace
}  // namespace procgen
