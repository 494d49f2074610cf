#include "envcore/world/entity.h"

#include "envcore/world/kinds.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

Entity AtRest(int kind) { return Entity::Make(kind, 1, 2, 0, 0, 0.5F, 0.25F); }

TEST(EntityTest, StartsWithTheValuesOfTheSpecification) {
  const Entity entity = AtRest(7);
  EXPECT_EQ(entity.image_kind, 7);
  EXPECT_EQ(entity.layer, 0);
  EXPECT_EQ(entity.shot_step, -1);
  EXPECT_EQ(entity.spawn_step, -1);
  EXPECT_EQ(entity.expiry, -1);
  EXPECT_EQ(entity.angle, -100);
  EXPECT_EQ(entity.friction, 1);
  EXPECT_EQ(entity.growth, 1);
  EXPECT_EQ(entity.fading, 1);
  EXPECT_EQ(entity.health, 1);
  EXPECT_TRUE(entity.auto_remove);
  EXPECT_FALSE(entity.smart);
  EXPECT_FALSE(entity.meets_entities);
}

TEST(EntityTest, ExplosionsGrowAndExpire) {
  const Entity explosion = AtRest(kExplosionKind);
  EXPECT_EQ(explosion.growth, 1.4F);
  EXPECT_EQ(explosion.expiry, 4);
  EXPECT_EQ(explosion.fading, 1);
}

TEST(EntityTest, TrailsGrowAndFadeWithoutExpiring) {
  const Entity trail = AtRest(kTrailKind);
  EXPECT_EQ(trail.growth, 1.05F);
  EXPECT_EQ(trail.fading, 0.8F);
  EXPECT_EQ(trail.expiry, -1);
}

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

TEST(EntityTest, OtherEntitiesKeepTheirImage) {
  Entity entity = AtRest(kExplosionKind + 1);
  entity.Step();
  EXPECT_EQ(entity.image_kind, kExplosionKind + 1);
}

TEST(EntityTest, MovesByItsVelocityBeforeFrictionSlowsIt) {
  Entity entity = Entity::Make(7, 1, 2, 0.5F, -0.25F, 0.5F, 0.5F);
  entity.friction = 0.5F;
  entity.Step();
  EXPECT_EQ(entity.x, 1.5F);
  EXPECT_EQ(entity.y, 1.75F);
  EXPECT_EQ(entity.vx, 0.25F);
  EXPECT_EQ(entity.vy, -0.125F);
}

TEST(EntityTest, SmartEntitiesAreNotMovedAgain) {
  Entity entity = Entity::Make(7, 1, 2, 0.5F, 0.5F, 0.5F, 0.5F);
  entity.smart = true;
  entity.friction = 0.5F;
  entity.Step();
  EXPECT_EQ(entity.x, 1);
  EXPECT_EQ(entity.y, 2);
  EXPECT_EQ(entity.vx, 0.25F);
}

TEST(EntityTest, TurnsGrowsAndFades) {
  Entity entity = AtRest(7);
  entity.spin = 0.25F;
  entity.growth = 1.5F;
  entity.fading = 0.5F;
  entity.Step();
  EXPECT_EQ(entity.rotation, 0.25F);
  EXPECT_EQ(entity.rx, 0.75F);
  EXPECT_EQ(entity.ry, 0.375F);
  EXPECT_EQ(entity.opacity, 0.5F);
}

TEST(EntityTest, IsMarkedOnceItHasLivedLongerThanItsExpiry) {
  Entity entity = AtRest(7);
  entity.expiry = 1;
  entity.Step();
  EXPECT_FALSE(entity.marked);
  entity.Step();
  EXPECT_TRUE(entity.marked);
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
