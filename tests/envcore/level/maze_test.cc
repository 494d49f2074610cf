#include "envcore/level/maze.h"

#include "envcore/world/kinds.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

int CountPlaced(const Maze& maze) {
  int count = 0;
  for (int cell = 0; cell < maze.size() * maze.size(); ++cell) {
    const int kind = maze.At(cell % maze.size(), cell / maze.size());
    count += kind == kWallKind || kind == kEmptyKind ? 0 : 1;
  }
  return count;
}

TEST(MazeTest, MazeOfOneCellHasNoPartitionAndKeepsItsKind) {
  RandomStream random(0);
  Maze maze(1);
  maze.MakePlain(random);
  EXPECT_EQ(maze.At(0, 0), 0);
  EXPECT_EQ(random.draws(), 0U);
}

TEST(MazeTest, HasAtMostAsManyDoorsAsForks) {
  RandomStream random(4);
  Maze maze(3);  // a tree of four rooms has at most one fork
  const int door_count = maze.MakeWithDoors(random, 9);
  EXPECT_LE(door_count, 1);
  EXPECT_EQ(CountPlaced(maze), 2 + 2 * door_count) << "start, exit, doors and their keys";
}

TEST(MazeTest, TakesNoDrawForDoorsIfThereAreFewerForks) {
  RandomStream random(4);
  Maze maze(3);  // this one has no fork
  EXPECT_EQ(maze.MakeWithDoors(random, 2), 0);
  EXPECT_EQ(random.draws(), 4U + 2U) << "walls, and the cells of start and exit";
}

}  // namespace
}  // namespace procgen
