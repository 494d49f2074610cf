#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/games/staged_game.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr int kCheeseKind = 2;

const Legend& MazeLegend() {
  static const Legend legend = {{'.', kEmptyKind}, {'#', kWallKind}, {'c', kCheeseKind}};
  return legend;
}

// A maze of the given cells with the mouse in cell (x, y).
std::unique_ptr<Game> StagedMaze(const Drawing& rows, int x, int y) {
  auto game = StartedGame("maze", 0, {.distribution_mode = DistributionMode::kEasy});
  World& world = Stage(*game);
  DrawGrid(rows, MazeLegend(), &world.grid);
  world.agent().x = static_cast<float>(x) + 0.5F;
  world.agent().y = static_cast<float>(y) + 0.5F;
  return game;
}

TEST(MazeGameTest, TheCheesePaysOnceAndCompletesTheLevel) {
  const auto game = StagedMaze({"..c"}, 1, 0);
  game->Play(7);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
  EXPECT_THAT(Drawn(game->world().grid, MazeLegend()), ElementsAre("..."));
}

TEST(MazeGameTest, VelocityIsNeverShown) {
  for (const DistributionMode mode : FindGame("maze")->modes) {
    const auto game = StartedGame("maze", 0, {.distribution_mode = mode, .paint_vel_info = true});
    Scene scene;
    game->FillScene(&scene);
    EXPECT_FALSE(scene.velocity.shown) << DistributionModeName(mode);
  }
}

}  // namespace
}  // namespace procgen
