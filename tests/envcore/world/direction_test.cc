#include "envcore/world/direction.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(DirectionTest, ArtThatFacesRightIsTurnedClockwiseToLookDown) {
  Entity entity;
  TurnTo(entity, 0, -1, 0);
  EXPECT_EQ(entity.rotation, kHalfPi);
}

TEST(DirectionTest, TheOffsetIsAdded) {
  Entity entity;
  TurnTo(entity, 1, 0, -kHalfPi);
  EXPECT_EQ(entity.rotation, -kHalfPi);
}

TEST(DirectionTest, AZeroDirectionKeepsTheRotation) {
  Entity entity;
  entity.rotation = 0.25F;
  TurnTo(entity, 0, 0, kPi);
  EXPECT_EQ(entity.rotation, 0.25F);
}

}  // namespace
}  // namespace procgen
