#include "tools/solver/goal_map.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {
namespace {

constexpr int kGemKind = 9;
constexpr int kKeyKind = 2;
constexpr int kLockKind = 1;
constexpr int kClosed[] = {kWallKind};
constexpr SearchHeuristic kHeuristic = {.game = "heist",
                                        .goal_kind = kGemKind,
                                        .key_kind = kKeyKind,
                                        .lock_kind = kLockKind,
                                        .closed_kinds = kClosed};
const Drawing kBend = {"#####",  //
                       "#...#",  //
                       "#.#.#",  //
                       "#.###"};

void Add(World& world, int kind, int x, int y, int theme = 0) {
  world.entities
      .emplace_back(Entity::Make(kind, static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F,
                                 0, 0, 0.5F, 0.5F))
      .theme = theme;
}

TEST(GoalMapTest, CountsCellsAroundWalls) {
  World world = DrawWorld(kBend, 1.5F, 0.5F);
  Add(world, kGemKind, 3, 1);
  const GoalDistance distance = GoalMap(kHeuristic).From(world);
  EXPECT_EQ(distance.cells, 5);
  EXPECT_EQ(distance.targets_left, 1);
  EXPECT_TRUE(distance.has_way);
}

TEST(GoalMapTest, AGoalCanBeACell) {
  World world = DrawWorld(kBend, 1.5F, 0.5F);
  world.grid.Set(2, 2, kGemKind);
  EXPECT_EQ(GoalMap(kHeuristic).From(world).cells, 3);
}

TEST(GoalMapTest, ALockedGoalIsReachedThroughItsKey) {
  World world = DrawWorld(kBend, 1.5F, 2.5F);
  Add(world, kGemKind, 3, 1);
  Add(world, kLockKind, 2, 2, /*theme=*/1);
  Add(world, kKeyKind, 1, 0, /*theme=*/1);
  GoalMap map(kHeuristic);
  EXPECT_EQ(map.From(world).cells, 2);
  EXPECT_EQ(map.From(world).targets_left, 2);
  world.entities.pop_back();  // the key is taken: the lock will open
  EXPECT_EQ(map.From(world).cells, 3);
  EXPECT_EQ(map.From(world).targets_left, 1);
}

TEST(GoalMapTest, WallsWithoutAGapLeaveNoPath) {
  World world = DrawWorld({"..#.",  //
                           "..#.",  //
                           "...#"},
                          0.5F, 0.5F);
  Add(world, kGemKind, 3, 2);
  EXPECT_FALSE(GoalMap(kHeuristic).From(world).has_way);
}

}  // namespace
}  // namespace procgen
