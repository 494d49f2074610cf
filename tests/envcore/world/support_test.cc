#include "envcore/world/support.h"

#include "gtest/gtest.h"

namespace procgen {
namespace {

bool IsWall(int kind) { return kind == kWallKind; }

// A world of 4 x 4 cells with one wall cell at (1, 0). The bottom edge of a box of half-sizes 0.4
// is `height` above the wall.
class SupportTest : public testing::Test {
 protected:
  SupportTest() {
    world_.grid.Reset(4, 4, kEmptyKind);
    world_.grid.Set(1, 0, kWallKind);
  }

  bool StandsAt(float x, float height) const {
    return StandsOn(world_, Entity::Make(kAgentKind, x, 1.4F + height, 0, 0, 0.4F, 0.4F), IsWall);
  }

  World world_;
};

TEST_F(SupportTest, ExtendsAHundredthOfACellBelowTheFeet) {
  EXPECT_TRUE(StandsAt(1.5F, 0));
  EXPECT_TRUE(StandsAt(1.5F, 0.009F));
  EXPECT_FALSE(StandsAt(1.5F, 0.011F));
}

TEST_F(SupportTest, OneEndOfTheFeetIsEnough) {
  EXPECT_TRUE(StandsAt(0.7F, 0));
  EXPECT_TRUE(StandsAt(2.3F, 0));
}

TEST_F(SupportTest, EndsAHundredthOfACellInsideTheBox) {
  EXPECT_FALSE(StandsAt(0.605F, 0));
  EXPECT_TRUE(StandsAt(0.615F, 0));
  EXPECT_TRUE(StandsAt(2.385F, 0));
  EXPECT_FALSE(StandsAt(2.395F, 0));
}

TEST_F(SupportTest, OutsideTheWorldTheOutOfBoundsKindCounts) {
  const Entity on_bottom = Entity::Make(kAgentKind, 3.5F, 0.4F, 0, 0, 0.4F, 0.4F);
  EXPECT_FALSE(StandsOn(world_, on_bottom, IsWall));
  world_.out_of_bounds_kind = kWallKind;
  EXPECT_TRUE(StandsOn(world_, on_bottom, IsWall));
}

}  // namespace
}  // namespace procgen
