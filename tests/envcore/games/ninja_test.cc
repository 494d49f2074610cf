#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

constexpr int kBombKind = 6;
constexpr int kStarKind = 7;
constexpr int kFireKind = 14;
constexpr int kBricksKind = 20;

constexpr int32_t kThrow = 9;

// A floor with the agent on it at x = 5.5, nothing else.
std::unique_ptr<Game> StagedFloor() {
  auto game = StartedGame("ninja", 0);
  StageAgentAlone(*game, 5.5F, 1.5F);
  Stage(*game).grid.Fill(0, 0, game->world().grid.width(), 1, kBricksKind);
  return game;
}

void PlayFor(Game& game, int steps, int32_t action) {
  for (int i = 0; i < steps; ++i) {
    game.Play(action);
  }
}

TEST(NinjaTest, AStarExplodesABombAndTheExplosionKills) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(8, 1, kBombKind);
  PlayFor(*game, 3, kThrow);
  PlayFor(*game, 3, kNoAction);
  EXPECT_EQ(game->world().grid.At(8, 1), kEmptyKind);
  EXPECT_EQ(CountEntities(*game, kStarKind), 0);
  ASSERT_EQ(CountEntities(*game, kExplosionKind), 1);
  EXPECT_FALSE(game->outcome().done);
  Stage(*game).agent().x = 8;
  game->Play(kNoAction);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_EQ(game->outcome().reward, 0);
}

TEST(NinjaTest, AStarFliesThroughFire) {
  const auto game = StagedFloor();
  Stage(*game).grid.Set(8, 1, kFireKind);
  PlayFor(*game, 3, kThrow);
  PlayFor(*game, 6, kNoAction);
  EXPECT_EQ(game->world().grid.At(8, 1), kFireKind);
  EXPECT_GT(game->world().entities.back().x, 9);
}

}  // namespace
}  // namespace procgen
