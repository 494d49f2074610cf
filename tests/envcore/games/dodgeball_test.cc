#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kLavaKind = 1;
constexpr int kBallKind = 3;
constexpr int kEnemyKind = 4;
constexpr int kDoorKind = 5;
constexpr int kEnemyBallKind = 6;

// An empty hall with the agent at (10, 10).
std::unique_ptr<Game> StagedHall() {
  auto game = StartedGame("dodgeball", 0);
  StageAgentAlone(*game, 10, 10);
  return game;
}

Entity& AddAt(Game& game, int kind, float x, float y) {
  Entity& entity = Stage(game).entities.emplace_back(Entity::Make(kind, x, y, 0, 0, 0.5F, 0.5F));
  entity.meets_entities = kind == kLavaKind || kind == kEnemyKind;
  return entity;
}

TEST(DodgeballTest, EnemiesTheirBallsAndLavaKillAndOwnBallsDoNot) {
  for (const int kind : {kEnemyKind, kEnemyBallKind, kLavaKind, kBallKind}) {
    const auto game = StagedHall();
    AddAt(*game, kind, 10, 10);
    game->Play(kNoAction);
    EXPECT_EQ(game->outcome().done, kind != kBallKind) << kind;
    EXPECT_EQ(game->outcome().reward, 0);
  }
}

// The door uses the number of enemies counted in the previous step.
TEST(DodgeballTest, TheDoorOpensInTheStepAfterTheLastEnemyIsGone) {
  const auto game = StagedHall();
  AddAt(*game, kDoorKind, 10, 10);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 0);
  EXPECT_FALSE(game->outcome().done);
  game->Play(kNoAction);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().level_complete);
}

}  // namespace
}  // namespace procgen
