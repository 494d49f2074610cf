#include "envcore/world/placing.h"

#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {
namespace {

constexpr int kBallKind = 8;

const Drawing kEmptyRoom = {"....", "....", "....", "...."};

TEST(DrawCenterTest, TakesOneDrawAndStaysInsideTheInterval) {
  RandomStream random(3);
  RandomStream same(3);
  const float expected = ((6.0F - 2.0F) - 2 * 0.5F) * same.Unit() + 0.5F + 2.0F;
  EXPECT_EQ(DrawCenter(random, 2, 6, 0.5F), expected);
  EXPECT_EQ(random.draws(), 1U);
}

TEST(DrawCenterTest, TakesTheMiddleWithoutADrawWhenItJustFitsOrDoesNot) {
  RandomStream random(3);
  EXPECT_EQ(DrawCenter(random, 2, 4, 1), 3);
  EXPECT_EQ(DrawCenter(random, 2, 4, 5), 3);
  EXPECT_EQ(random.draws(), 0U);
}

TEST(SpawnInBoxTest, DrawsXThenYAndAppendsAtRest) {
  World world = DrawWorld(kEmptyRoom, -9, -9);
  RandomStream random(3);
  RandomStream same(3);
  const float x = DrawCenter(same, 0, 4, 0.5F);
  const float y = DrawCenter(same, 1, 3, 0.25F);
  const Entity& ball =
      SpawnInBox(world, random, kBallKind, 0.5F, 0.25F, {.x = 0, .y = 1, .width = 4, .height = 2});
  EXPECT_EQ(&ball, &world.entities.back());
  EXPECT_EQ(ball.x, x);
  EXPECT_EQ(ball.y, y);
  EXPECT_EQ(ball.vx, 0);
  EXPECT_EQ(random.draws(), 2U);
}

TEST(SpawnInBoxTest, GivesUpAfterAHundredMoreAttempts) {
  World world = DrawWorld(kEmptyRoom, 2, 2, 10);
  RandomStream random(3);
  SpawnInBox(world, random, kBallKind, 0.5F, 0.5F, {.width = 4, .height = 4});
  EXPECT_EQ(random.draws(), 2U + 200U);
  EXPECT_EQ(world.entities.size(), 2U);
}

TEST(SpawnInBoxTest, AvoidsOtherEntitiesOnlyOnRequest) {
  World world = DrawWorld(kEmptyRoom, -9, -9);
  world.entities.push_back(Entity::Make(kBallKind, 2, 2, 0, 0, 10, 10));
  RandomStream random(3);
  SpawnInBox(world, random, kBallKind, 0.5F, 0.5F, {.width = 4, .height = 4},
             CollisionCheck::kAgentOnly);
  EXPECT_EQ(random.draws(), 2U);
  SpawnInBox(world, random, kBallKind, 0.5F, 0.5F, {.width = 4, .height = 4});
  EXPECT_EQ(random.draws(), 2U + 202U);
}

TEST(SpawnInBoxTest, MayOverlapEntitiesThatAvoidCollisionsButNotTheAgent) {
  World world = DrawWorld(kEmptyRoom, -9, -9);
  world.entities.push_back(Entity::Make(kBallKind, 2, 2, 0, 0, 10, 10));
  world.entities.back().avoids_collisions = true;
  RandomStream random(3);
  SpawnInBox(world, random, kBallKind, 0.5F, 0.5F, {.width = 4, .height = 4});
  EXPECT_EQ(random.draws(), 2U);
  world.agent().avoids_collisions = true;
  world.agent().x = 2;
  world.agent().y = 2;
  world.agent().rx = 10;
  world.agent().ry = 10;
  SpawnInBox(world, random, kBallKind, 0.5F, 0.5F, {.width = 4, .height = 4});
  EXPECT_EQ(random.draws(), 2U + 202U);
}

TEST(SpawnAtCellTest, IsAtTheCenterOfTheCell) {
  World world = DrawWorld({"...", "...", "..."}, 0.5F, 0.5F);
  const Entity& ball = SpawnAtCell(world, kBallKind, 0.25F, 5);
  EXPECT_EQ(ball.x, 2.5F);
  EXPECT_EQ(ball.y, 1.5F);
  EXPECT_EQ(ball.rx, 0.25F);
  EXPECT_EQ(ball.ry, 0.25F);
}

TEST(SpawnChildTest, TakesTheParentsPositionAndOptionallyItsVelocity) {
  World world = DrawWorld(kEmptyRoom, 1, 2);
  const Entity parent = Entity::Make(kBallKind, 1, 2, 0.5F, -0.5F, 0.5F, 0.5F);
  const Entity resting = SpawnChild(world, kBallKind, 0.1F, parent, false);
  const Entity moving = SpawnChild(world, kBallKind, 0.1F, parent, true);
  EXPECT_EQ(resting.x, 1);
  EXPECT_EQ(resting.y, 2);
  EXPECT_EQ(resting.vx, 0);
  EXPECT_EQ(moving.vx, 0.5F);
  EXPECT_EQ(moving.vy, -0.5F);
}

// Here the parent is an entity of the world, whose list may be reallocated.
TEST(SpawnChildTest, TheParentMayBeInTheWorld) {
  World world = DrawWorld(kEmptyRoom, 1, 2);
  world.entities.shrink_to_fit();
  const Entity child = SpawnChild(world, kBallKind, 0.1F, world.agent(), true);
  EXPECT_EQ(child.x, 1);
  EXPECT_EQ(child.y, 2);
}

TEST(SpawnDustTest, RisesFromTheFeetForNineSteps) {
  World world = DrawWorld(kEmptyRoom, 1, 2);
  const Entity& dust = SpawnDust(world, world.agent());
  EXPECT_EQ(dust.kind, kTrailKind);
  EXPECT_EQ(dust.x, 1);
  EXPECT_EQ(dust.y, 1.8F);
  for (int step = 0; step < 8; ++step) {
    world.entities.back().Step();
  }
  EXPECT_FALSE(world.entities.back().marked);
  EXPECT_GT(world.entities.back().y, 1.8F);
  world.entities.back().Step();
  EXPECT_TRUE(world.entities.back().marked);
}

TEST(PlaceAgentAnewTest, TakesTwoDrawsAnAttempt) {
  World world = DrawWorld(kEmptyRoom, 0, 0);
  RandomStream random(3);
  RandomStream same(3);
  const float x = same.Unit() * (4 - 2 * 0.4F) + 0.4F;
  const float y = same.Unit() * (4 - 2 * 0.4F) + 0.4F;
  PlaceAgentAtRandom(world, random);
  EXPECT_EQ(world.agent().x, x);
  EXPECT_EQ(world.agent().y, y);
  EXPECT_EQ(random.draws(), 2U);
}

TEST(PlaceAgentAnewTest, GivesUpAfterAHundredAttempts) {
  World world = DrawWorld(kEmptyRoom, 0, 0);
  world.entities.push_back(Entity::Make(kBallKind, 2, 2, 0, 0, 10, 10));
  RandomStream random(3);
  PlaceAgentAtRandom(world, random);
  EXPECT_EQ(random.draws(), 200U);
}

TEST(PlaceAgentAnewTest, TheMarginOfTheOtherEntityCounts) {
  World world = DrawWorld(kEmptyRoom, 0, 0);
  world.entities.push_back(Entity::Make(kBallKind, 2, 2, 0, 0, 0.1F, 0.1F));
  world.entities.back().contact_margin = 10;
  RandomStream random(3);
  PlaceAgentAtRandom(world, random);
  EXPECT_EQ(random.draws(), 200U);
}

TEST(OverlapsAnythingTest, TouchingIsNotOverlapping) {
  World world = DrawWorld(kEmptyRoom, 0, 0);
  world.entities.push_back(Entity::Make(kBallKind, 2, 2, 0, 0, 0.5F, 0.5F));
  EXPECT_FALSE(OverlapsAnything(world, Entity::Make(kBallKind, 3, 2, 0, 0, 0.5F, 0.5F)));
  EXPECT_TRUE(OverlapsAnything(world, Entity::Make(kBallKind, 2.9F, 2, 0, 0, 0.5F, 0.5F)));
}

TEST(DistanceTest, IsBetweenCenters) {
  EXPECT_EQ(Distance(Entity::Make(1, 1, 1, 0, 0, 9, 9), Entity::Make(1, 4, 5, 0, 0, 9, 9)), 5);
}

}  // namespace
}  // namespace procgen
