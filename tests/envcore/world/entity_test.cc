#include "envcore/world/entity.h"

#include "envcore/world/kinds.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

Entity AtRest(int kind) { return Entity::Make(kind, 1, 2, 0, 0, 0.5F, 0.25F); }

TEST(EntityTest, AnExplosionShowsFiveImagesAndIsMarkedInItsFifthStep) {
  Entity explosion = AtRest(kExplosionKind);
  for (const int image_kind : {55, 56, 57, 58}) {
    explosion.Step();
    EXPECT_EQ(explosion.image_kind, image_kind);
    EXPECT_FALSE(explosion.marked);
  }
  explosion.Step();
  EXPECT_EQ(explosion.image_kind, kLastExplosionKind);
  EXPECT_TRUE(explosion.marked);
}

TEST(EntityTest, ExpiryZeroNeverExpires) {
  Entity entity = AtRest(7);
  entity.expiry = 0;
  entity.Step();
  EXPECT_FALSE(entity.marked);
}

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
