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
using ::testing::ElementsAre;
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

// '#' wall, '.' open, S start, E exit, A B C doors, a b c their keys; top row first.
std::vector<std::string> Drawn(const Maze& maze) {
  std::vector<std::string> rows;
  for (int y = maze.size() - 1; y >= 0; --y) {
    std::string& row = rows.emplace_back();
    for (int x = 0; x < maze.size(); ++x) {
      const int kind = maze.At(x, y);
      if (kind >= kMazeKeyKind) {
        row += static_cast<char>('a' + kind - kMazeKeyKind);
      } else if (kind >= kMazeDoorKind) {
        row += static_cast<char>('A' + kind - kMazeDoorKind);
      } else {
        row += kind == kWallKind        ? '#'
               : kind == kEmptyKind     ? '.'
               : kind == kMazeStartKind ? 'S'
               : kind == kExitKind      ? 'E'
                                        : '?';
      }
    }
  }
  return rows;
}

// A level's stream after the draws that the game takes before it makes the maze.
RandomStream StreamOfLevel(int level_seed, int draws_before) {
  RandomStream random(level_seed);
  for (int i = 0; i < draws_before; ++i) {
    random.Raw();
  }
  return random;
}

int PartitionCount(int size) { return 2 * ((size - 1) / 2) * ((size + 1) / 2); }

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

TEST_P(MazeSizesTest, TakesOneDrawForEachPartition) {
  RandomStream random(5);
  Maze maze(GetParam());
  maze.MakePlain(random);
  EXPECT_EQ(static_cast<int>(random.draws()), PartitionCount(GetParam()));
}

TEST_P(MazeSizesTest, ListsEachOpenCellOnce) {
  RandomStream random(6);
  Maze maze(GetParam());
  maze.MakePlain(random);
  const std::vector<int32_t>& listed = maze.open_cells();
  const Cells set(listed.begin(), listed.end());
  EXPECT_EQ(set.size(), listed.size());
  EXPECT_EQ(set, CellsWithout(maze, {kWallKind}));
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

TEST_P(MazeSizesTest, WithoutDeadEndsTakesOneMoreDrawForEachCellItOpens) {
  RandomStream random(7);
  RandomStream same(7);
  Maze plain(GetParam());
  plain.MakePlain(same);
  Maze maze(GetParam());
  maze.MakeWithoutDeadEnds(random);
  const size_t opened =
      CellsWithout(maze, {kWallKind}).size() - CellsWithout(plain, {kWallKind}).size();
  EXPECT_EQ(random.draws() - same.draws(), opened);
  EXPECT_EQ(maze.open_cells(), plain.open_cells()) << "cells opened later are not listed";
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

TEST(MazeTest, MazeOfEvenSizeKeepsItsLastColumnAndRowAsWall) {
  RandomStream random(0);
  Maze maze(6);
  maze.MakePlain(random);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(maze.At(5, i), kWallKind);
    EXPECT_EQ(maze.At(i, 5), kWallKind);
  }
}

TEST(MazeTest, EachCallMakesANewMaze) {
  RandomStream random(0);
  Maze maze(9);
  maze.MakePlain(random);
  random.Seed(0);
  const std::vector<int32_t> first = maze.open_cells();
  maze.MakePlain(random);
  EXPECT_EQ(maze.open_cells(), first);
}

TEST(MazeTest, ObjectsLieInDifferentOpenCellsOtherThanTheCorner) {
  for (int seed = 0; seed < 50; ++seed) {
    RandomStream random(seed);
    Maze maze(3);
    maze.MakePlain(random);
    maze.PlaceObjects(random, 6, 80);  // of seven open cells: all except the corner
    EXPECT_EQ(maze.At(0, 0), kEmptyKind);
    for (int kind = 80; kind < 86; ++kind) {
      EXPECT_THAT(maze.open_cells(), Contains(CellOfKind(maze, kind)));
    }
  }
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
  const int start_and_exit = 2;
  EXPECT_EQ(static_cast<int>(random.draws()), PartitionCount(3) + start_and_exit);
}

TEST(MazeTest, DoorsAreInForksAndNotBesideTheStart) {
  for (int seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomStream random(seed);
    Maze plain(7 + 2 * (seed % 5));
    plain.MakePlain(random);
    random.Seed(seed);
    Maze maze(plain.size());
    const int door_count = maze.MakeWithDoors(random, 1 + seed % 3);
    const std::vector<int> around_start = Neighbors(maze, CellOfKind(maze, kMazeStartKind));
    for (int door = 0; door < door_count; ++door) {
      const int cell = CellOfKind(maze, kMazeDoorKind + door);
      const std::vector<int> around_door = Neighbors(maze, cell);
      const auto ways =
          std::count_if(around_door.begin(), around_door.end(),
                        [&plain](int neighbor) { return KindAt(plain, neighbor) == kEmptyKind; });
      EXPECT_GT(ways, 2);
      EXPECT_THAT(around_start, Not(Contains(cell)));
    }
  }
}

// The maze of level 1000 of chaser's easy mode, from a recording of Procgen 0.10.7.
TEST(MazeTest, MazeWithoutDeadEndsMatchesTheRecording) {
  RandomStream random = StreamOfLevel(1000, 4);
  Maze maze(11);
  maze.MakeWithoutDeadEnds(random);
  EXPECT_THAT(Drawn(maze), ElementsAre("...........",  //
                                       ".#######.#.",  //
                                       "...........",  //
                                       "######.#.#.",  //
                                       ".....#.#...",  //
                                       ".###.#.#.##",  //
                                       "...........",  //
                                       ".#.#######.",  //
                                       ".#.........",  //
                                       ".#.###.#.#.",  //
                                       ".......#..."));
}

// The maze of level 1001 of heist's hard mode, from a recording of Procgen 0.10.7.
TEST(MazeTest, MazeWithDoorsMatchesTheRecording) {
  RandomStream random = StreamOfLevel(1001, 6);
  Maze maze(7);
  EXPECT_EQ(maze.MakeWithDoors(random, 2), 2);
  EXPECT_THAT(Drawn(maze), ElementsAre(".aS#...",  //
                                       "##.#.#.",  //
                                       ".#.#.#.",  //
                                       ".#.#.##",  //
                                       ".#A..b.",  //
                                       ".#.####",  //
                                       "..B.E.."));
}

}  // namespace
}  // namespace procgen
