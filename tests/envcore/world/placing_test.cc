#include "envcore/world/placing.h"

#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {
namespace {

constexpr int kBallKind = 8;

const Drawing kEmptyRoom = {"....", "....", "....", "...."};

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

// Here the parent is an entity of the world, whose list may be reallocated.
TEST(SpawnChildTest, TheParentMayBeInTheWorld) {
  World world = DrawWorld(kEmptyRoom, 1, 2);
  world.entities.shrink_to_fit();
  const Entity child = SpawnChild(world, kBallKind, 0.1F, world.agent(), true);
  EXPECT_EQ(child.x, 1);
  EXPECT_EQ(child.y, 2);
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

}  // namespace
}  // namespace procgen
