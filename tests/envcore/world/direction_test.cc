#include "envcore/world/direction.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(DirectionTest, AZeroDirectionKeepsTheRotation) {
  Entity entity;
  entity.rotation = 0.25F;
  TurnTo(entity, 0, 0, kPi);
  EXPECT_EQ(entity.rotation, 0.25F);
}

}  // namespace
}  // namespace procgen
