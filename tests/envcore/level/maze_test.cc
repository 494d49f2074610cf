#include "envcore/level/maze.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "envcore/world/kinds.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::Ge;
using ::testing::Not;

using Cells = std::set<int>;

// The neighbors of a cell, as y * size + x.
std::vector<int> Neighbors(const Maze& maze, int cell) {
  const int x = cell % maze.size();
  const int y = cell / maze.size();
  std::vector<int> neighbors;
  for (const auto& [dx, dy] : std::vector<std::pair<int, int>>{{-1, 0}, {0, -1}, {0, 1}, {1, 0}}) {
    if (x + dx >= 0 && x + dx < maze.size() && y + dy >= 0 && y + dy < maze.size()) {
      neighbors.push_back((y + dy) * maze.size() + x + dx);
    }
  }
  return neighbors;
}

int KindAt(const Maze& maze, int cell) { return maze.At(cell % maze.size(), cell / maze.size()); }

Cells CellsWithout(const Maze& maze, const std::set<int>& kinds) {
  Cells cells;
  for (int cell = 0; cell < maze.size() * maze.size(); ++cell) {
    if (!kinds.contains(KindAt(maze, cell))) {
      cells.insert(cell);
    }
  }
  return cells;
}

// All cells reachable from `start` without entering cells of the kinds `closed`.
Cells Reachable(const Maze& maze, int start, const std::set<int>& closed) {
  Cells reached = {start};
  std::vector<int> front = {start};
  while (!front.empty()) {
    const int cell = front.back();
    front.pop_back();
    for (const int neighbor : Neighbors(maze, cell)) {
      if (!closed.contains(KindAt(maze, neighbor)) && reached.insert(neighbor).second) {
        front.push_back(neighbor);
      }
    }
  }
  return reached;
}

int CellOfKind(const Maze& maze, int kind) {
  std::vector<int> found;
  for (int cell = 0; cell < maze.size() * maze.size(); ++cell) {
    if (KindAt(maze, cell) == kind) {
      found.push_back(cell);
    }
  }
  EXPECT_EQ(found.size(), 1U) << "kind " << kind;
  return found.empty() ? 0 : found[0];
}

class MazeSizesTest : public testing::TestWithParam<int> {};

TEST_P(MazeSizesTest, OnePathConnectsAnyTwoRooms) {
  for (int seed = 0; seed < 20; ++seed) {
    RandomStream random(seed);
    Maze maze(GetParam());
    maze.MakePlain(random);
    const Cells open = CellsWithout(maze, {kWallKind});
    const int room_count = (GetParam() + 1) / 2 * ((GetParam() + 1) / 2);
    EXPECT_EQ(Reachable(maze, 0, {kWallKind}), open) << "all are joined";
    EXPECT_EQ(static_cast<int>(open.size()), 2 * room_count - 1)
        << "by one passage fewer than rooms";
  }
}

TEST_P(MazeSizesTest, WithoutDeadEndsEveryOpenCellHasTwoWaysOut) {
  for (int seed = 0; seed < 20; ++seed) {
    RandomStream random(seed);
    Maze maze(GetParam());
    maze.MakeWithoutDeadEnds(random);
    std::vector<int> ways;
    for (const int cell : CellsWithout(maze, {kWallKind})) {
      const std::vector<int> neighbors = Neighbors(maze, cell);
      ways.push_back(
          static_cast<int>(std::count_if(neighbors.begin(), neighbors.end(), [&maze](int neighbor) {
            return KindAt(maze, neighbor) == kEmptyKind;
          })));
    }
    EXPECT_THAT(ways, Each(Ge(2))) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, MazeSizesTest, testing::Values(3, 5, 7, 11, 15, 25, 31),
                         [](const auto& info) { return std::to_string(info.param); });

TEST(MazeTest, MazeOfOneCellHasNoPartitionAndKeepsItsKind) {
  RandomStream random(0);
  Maze maze(1);
  maze.MakePlain(random);
  EXPECT_EQ(maze.At(0, 0), 0);
  EXPECT_EQ(random.draws(), 0U);
}

TEST(MazeTest, EachDoorsKeyIsInTheAreaBehindThePreviousDoor) {
  for (int seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomStream random(seed);
    Maze maze(7 + 2 * (seed % 5));
    const int door_count = maze.MakeWithDoors(random, 1 + seed % 3);
    const int start = CellOfKind(maze, kMazeStartKind);
    std::set<int> closed = {kWallKind};
    for (int door = 0; door < door_count; ++door) {
      closed.insert(kMazeDoorKind + door);
    }
    Cells had = {start};  // reachable with the keys so far
    for (int door = 0; door < door_count; ++door) {
      const Cells reached = Reachable(maze, start, closed);
      const int key = CellOfKind(maze, kMazeKeyKind + door);
      EXPECT_THAT(reached, Contains(key));
      EXPECT_THAT(had, Not(Contains(key)));
      had = reached;
      closed.erase(kMazeDoorKind + door);
    }
    const int exit = CellOfKind(maze, kExitKind);
    EXPECT_THAT(Reachable(maze, start, closed), Contains(exit));
    EXPECT_THAT(had, Not(Contains(exit)));
  }
}

TEST(MazeTest, HasAtMostAsManyDoorsAsForks) {
  RandomStream random(4);
  Maze maze(3);  // a tree of four rooms has at most one fork
  const int door_count = maze.MakeWithDoors(random, 9);
  EXPECT_LE(door_count, 1);
  EXPECT_EQ(static_cast<int>(CellsWithout(maze, {kWallKind, kEmptyKind}).size()),
            2 + 2 * door_count)
      << "start, exit, doors and their keys";
}

TEST(MazeTest, TakesNoDrawForDoorsIfThereAreFewerForks) {
  RandomStream random(4);
  Maze maze(3);  // this one has no fork
  EXPECT_EQ(maze.MakeWithDoors(random, 2), 0);
  EXPECT_EQ(random.draws(), 4U + 2U) << "walls, and the cells of start and exit";
}

}  // namespace
}  // namespace procgen
