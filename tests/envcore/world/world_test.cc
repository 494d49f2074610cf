#include "envcore/world/world.h"

#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {
namespace {

TEST(WorldTest, CellsOutsideHaveTheOutOfBoundsKind) {
  World world = DrawWorld({"...", "..."}, 1, 1);
  world.out_of_bounds_kind = 15;
  EXPECT_EQ(world.CellAt(-1, 0), 15);
  EXPECT_EQ(world.CellAt(0, -1), 15);
  EXPECT_EQ(world.CellAt(3, 0), 15);
  EXPECT_EQ(world.CellAt(0, 2), 15);
  EXPECT_EQ(world.CellAt(2, 1), kEmptyKind);
}

TEST(WorldTest, PointsLeftOfOrBelowTheOriginAreOutsideHoweverNear) {
  const World world = DrawWorld({"##", "##"}, 1, 1);
  EXPECT_EQ(world.CellAtPoint(-0.001F, 0.5F), kOutsideKind);
  EXPECT_EQ(world.CellAtPoint(0.5F, -0.001F), kOutsideKind);
  EXPECT_EQ(world.CellAtPoint(0, 0), kWallKind);
  EXPECT_EQ(world.CellAtPoint(1.999F, 1.999F), kWallKind);
  EXPECT_EQ(world.CellAtPoint(2, 0), kOutsideKind);
}

TEST(WorldTest, ABoxIsOutsideOnlyIfNoPartTouchesTheWorld) {
  const World world = DrawWorld({"...", "..."}, 1, 1);
  const auto is_outside = [&world](float x, float y) {
    return world.IsOutside(Entity::Make(1, x, y, 0, 0, 0.5F, 0.5F));
  };
  EXPECT_FALSE(is_outside(-0.5F, 1));
  EXPECT_TRUE(is_outside(-0.51F, 1));
  EXPECT_FALSE(is_outside(1, -0.5F));
  EXPECT_TRUE(is_outside(1, -0.51F));
  EXPECT_FALSE(is_outside(3.5F, 1));
  EXPECT_TRUE(is_outside(3.51F, 1));
  EXPECT_FALSE(is_outside(1, 2.5F));
  EXPECT_TRUE(is_outside(1, 2.51F));
}

}  // namespace
}  // namespace procgen
