#include <set>
#include <vector>

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

struct Place {
  float x, y;
  bool operator==(const Place& other) const { return x == other.x && y == other.y; }
};

Place PlaceOf(const Game& game) { return {game.world().agent().x, game.world().agent().y}; }

TEST(MazeGameTest, ActionsMoveOneCellAndDiagonalsGoSideways) {
  const std::vector<Place> expected = {{0.5F, 1.5F}, {0.5F, 1.5F}, {0.5F, 1.5F}, {1.5F, 0.5F},
                                       {1.5F, 1.5F}, {1.5F, 2.5F}, {2.5F, 1.5F}, {2.5F, 1.5F},
                                       {2.5F, 1.5F}, {1.5F, 1.5F}, {1.5F, 1.5F}, {1.5F, 1.5F},
                                       {1.5F, 1.5F}, {1.5F, 1.5F}, {1.5F, 1.5F}};
  for (int32_t action = 0; action < kActionCount; ++action) {
    const auto game = StagedMaze({"...", "...", "..."}, 1, 1);
    game->Play(action);
    EXPECT_EQ(PlaceOf(*game), expected[static_cast<size_t>(action)]) << ActionName(action);
  }
}

TEST(MazeGameTest, WallsAndTheEdgeStopTheMouseAndDiagonalsDoNotSlide) {
  const auto game = StagedMaze({".#", ".."}, 0, 1);
  for (const int32_t action : {8, 2, 5}) {
    game->Play(action);
    EXPECT_EQ(PlaceOf(*game), (Place{0.5F, 1.5F})) << ActionName(action);
  }
}

TEST(MazeGameTest, TheMouseFacesWhereItSteersEvenWhenBlocked) {
  const auto game = StagedMaze({"#.#"}, 1, 0);
  std::vector<bool> mirrored;
  for (const int32_t action : {7, 4, 1, 5}) {
    game->Play(action);
    mirrored.push_back(game->world().agent().mirrored);
  }
  EXPECT_THAT(mirrored, ElementsAre(true, true, false, false));
}

TEST(MazeGameTest, TheCheesePaysOnceAndCompletesTheLevel) {
  const auto game = StagedMaze({"..c"}, 1, 0);
  game->Play(7);
  EXPECT_EQ(game->outcome().reward, 10);
  EXPECT_TRUE(game->outcome().done);
  EXPECT_TRUE(game->outcome().level_complete);
  EXPECT_THAT(Drawn(game->world().grid, MazeLegend()), ElementsAre("..."));
}

TEST(MazeGameTest, AStepTakesOneDraw) {
  const auto game = StartedGame("maze", 3);
  const uint64_t before = game->random().draws();
  game->Play(7);
  EXPECT_EQ(game->random().draws(), before + 1);
}

class MazeGameModesTest : public testing::TestWithParam<DistributionMode> {};

TEST_P(MazeGameModesTest, LevelsAreCenteredWithTheMouseInTheirCorner) {
  std::set<int> sizes;
  for (int32_t seed = 0; seed < 60; ++seed) {
    const auto game = StartedGame("maze", seed, {.distribution_mode = GetParam()});
    const World& world = game->world();
    const int corner = static_cast<int>(world.agent().x);
    const int size = world.grid.width() - 2 * corner;
    EXPECT_EQ(world.agent().x, world.agent().y);
    EXPECT_EQ(world.grid.At(corner, corner), kEmptyKind) << "no cheese at the start";
    EXPECT_EQ(size % 2, 1);
    sizes.insert(size);
    int cheese_count = 0;
    for (int cell = 0; cell < world.grid.size(); ++cell) {
      cheese_count += world.grid.At(cell) == kCheeseKind ? 1 : 0;
      const int x = cell % world.grid.width();
      const int y = cell / world.grid.width();
      if (x < corner || y < corner || x >= corner + size || y >= corner + size) {
        EXPECT_EQ(world.grid.At(cell), kWallKind);
      }
    }
    EXPECT_EQ(cheese_count, 1);
  }
  EXPECT_EQ(*sizes.begin(), 3);
  EXPECT_LE(*sizes.rbegin(),
            StartedGame("maze", 0, {.distribution_mode = GetParam()})->world().grid.width());
}

TEST_P(MazeGameModesTest, TheCameraFollowsTheMouseInMemoryModeOnly) {
  for (const bool center_agent : {false, true}) {
    const auto game =
        StartedGame("maze", 0, {.distribution_mode = GetParam(), .center_agent = center_agent});
    Scene scene;
    game->FillScene(&scene);
    if (GetParam() == DistributionMode::kMemory) {
      EXPECT_EQ(scene.camera.cells, 8);
      EXPECT_EQ(scene.camera.center_x, game->world().agent().x);
      EXPECT_EQ(scene.cells.out_of_bounds_kind, kWallKind);
    } else {
      EXPECT_EQ(scene.camera.cells, static_cast<float>(game->world().grid.width()));
      EXPECT_EQ(scene.camera.center_x, scene.camera.cells / 2);
    }
  }
}

TEST_P(MazeGameModesTest, VelocityIsNeverShown) {
  const auto game =
      StartedGame("maze", 0, {.distribution_mode = GetParam(), .paint_vel_info = true});
  Scene scene;
  game->FillScene(&scene);
  EXPECT_FALSE(scene.velocity.shown);
}

INSTANTIATE_TEST_SUITE_P(Modes, MazeGameModesTest,
                         testing::Values(DistributionMode::kEasy, DistributionMode::kHard,
                                         DistributionMode::kMemory),
                         [](const auto& info) {
                           return std::string(DistributionModeName(info.param));
                         });

}  // namespace
}  // namespace procgen
