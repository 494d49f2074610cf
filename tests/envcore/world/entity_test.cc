#include "envcore/world/entity.h"

#include "envcore/world/kinds.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(EntityTest, TouchingIsNotOverlapping) {
  const Entity a = Entity::Make(1, 0, 0, 0, 0, 0.5F, 0.5F);
  EXPECT_FALSE(Overlap(a, Entity::Make(2, 1, 0, 0, 0, 0.5F, 0.5F), 0));
  EXPECT_TRUE(Overlap(a, Entity::Make(2, 0.99F, 0, 0, 0, 0.5F, 0.5F), 0));
  EXPECT_FALSE(Overlap(a, Entity::Make(2, 0, 1, 0, 0, 0.5F, 0.5F), 0));
  EXPECT_TRUE(Overlap(a, Entity::Make(2, 0, -0.99F, 0, 0, 0.5F, 0.5F), 0));
}

TEST(EntityTest, TheMarginWidensTheBoxes) {
  const Entity a = Entity::Make(1, 0, 0, 0, 0, 0.5F, 0.5F);
  const Entity b = Entity::Make(2, 1.25F, 0, 0, 0, 0.5F, 0.5F);
  EXPECT_FALSE(Overlap(a, b, 0.25F));
  EXPECT_TRUE(Overlap(a, b, 0.26F));
}

}  // namespace
}  // namespace procgen
