#include "envcore/world/grid.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

TEST(GridTest, ContainsItsCellsAndNoOthers) {
  Grid grid;
  grid.Reset(3, 2, kEmptyKind);
  EXPECT_TRUE(grid.Contains(0, 0));
  EXPECT_TRUE(grid.Contains(2, 1));
  EXPECT_FALSE(grid.Contains(-1, 0));
  EXPECT_FALSE(grid.Contains(0, -1));
  EXPECT_FALSE(grid.Contains(3, 0));
  EXPECT_FALSE(grid.Contains(0, 2));
}

TEST(GridTest, FillOfNoColumnsOrRowsChangesNothing) {
  Grid grid;
  grid.Reset(2, 2, kEmptyKind);
  grid.Fill(0, 0, 0, 2, kWallKind);
  grid.Fill(0, 0, 2, 0, kWallKind);
  grid.Fill(0, 0, 2, -1, kWallKind);
  EXPECT_THAT(Drawn(grid, WallLegend()), ElementsAre("..", ".."));
}

}  // namespace
}  // namespace procgen
