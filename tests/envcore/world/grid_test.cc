#include "envcore/world/grid.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

TEST(GridTest, CellIndicesGoRowByRowFromTheBottomLeft) {
  Grid grid;
  grid.Reset(3, 2, kEmptyKind);
  grid.Set(1, 1, kWallKind);
  EXPECT_EQ(grid.IndexOf(1, 1), 4);
  EXPECT_EQ(grid.At(4), kWallKind);
  EXPECT_THAT(Drawn(grid, WallLegend()), ElementsAre(".#.", "..."));
}

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

TEST(GridTest, FillStopsBeforeTheFarEdges) {
  Grid grid;
  grid.Reset(5, 4, kEmptyKind);
  grid.Fill(1, 0, 3, 2, kWallKind);
  EXPECT_THAT(Drawn(grid, WallLegend()), ElementsAre(".....", ".....", ".###.", ".###."));
}

TEST(GridTest, FillOfNoColumnsOrRowsChangesNothing) {
  Grid grid;
  grid.Reset(2, 2, kEmptyKind);
  grid.Fill(0, 0, 0, 2, kWallKind);
  grid.Fill(0, 0, 2, 0, kWallKind);
  grid.Fill(0, 0, 2, -1, kWallKind);
  EXPECT_THAT(Drawn(grid, WallLegend()), ElementsAre("..", ".."));
}

TEST(GridTest, ResetReplacesSizeAndCells) {
  Grid grid;
  grid.Reset(4, 4, kWallKind);
  grid.Reset(2, 1, kEmptyKind);
  EXPECT_EQ(grid.size(), 2);
  EXPECT_THAT(Drawn(grid, WallLegend()), ElementsAre(".."));
}

}  // namespace
}  // namespace procgen
