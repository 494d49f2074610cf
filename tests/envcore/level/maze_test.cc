// Mazes of all kinds: what holds for every maze, over many sizes and seeds, and one maze of each
// kind as the released benchmark made it.

#include "envcore/level/maze.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "envcore/world/kinds.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::Le;
using ::testing::UnorderedElementsAreArray;

constexpr int kObjectKind = 2;
constexpr int kSizes[] = {3, 5, 7, 9, 13, 25};
constexpr int kSeedCount = 20;

// '#' wall, '.' open, S start, E exit, A B C doors, a b c their keys; the top row first.
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

std::vector<int> CellsOfKind(const Maze& maze, int kind) {
  std::vector<int> cells;
  for (int cell = 0; cell < maze.size() * maze.size(); ++cell) {
    if (maze.At(cell % maze.size(), cell / maze.size()) == kind) {
      cells.push_back(cell);
    }
  }
  return cells;
}

// The cells beside `cell` that lie in the maze.
std::vector<int> Beside(const Maze& maze, int cell) {
  const int x = cell % maze.size();
  const int y = cell / maze.size();
  std::vector<int> cells;
  if (x > 0) {
    cells.push_back(cell - 1);
  }
  if (y > 0) {
    cells.push_back(cell - maze.size());
  }
  if (y < maze.size() - 1) {
    cells.push_back(cell + maze.size());
  }
  if (x < maze.size() - 1) {
    cells.push_back(cell + 1);
  }
  return cells;
}

int KindOf(const Maze& maze, int cell) { return maze.At(cell % maze.size(), cell / maze.size()); }

// Where one can get from `start` without going through walls and closed doors; doors from
// `closed_from` on are closed.
std::set<int> Reachable(const Maze& maze, int start, int closed_from) {
  std::set<int> reached = {start};
  std::vector<int> front = {start};
  while (!front.empty()) {
    const int cell = front.back();
    front.pop_back();
    for (const int next : Beside(maze, cell)) {
      const int kind = KindOf(maze, next);
      const bool closed = kind >= kMazeDoorKind + closed_from && kind < kMazeKeyKind;
      if (kind != kWallKind && !closed && reached.insert(next).second) {
        front.push_back(next);
      }
    }
  }
  return reached;
}

// The stream of a level after the draws that its game takes before it makes the maze.
RandomStream StreamOfLevel(int level_seed, int draws_before) {
  RandomStream random(level_seed);
  for (int i = 0; i < draws_before; ++i) {
    random.Raw();
  }
  return random;
}

// Calls `check` with the size of a maze and the stream that is to make it.
template <typename Check>
void ForManyMazes(Check check) {
  for (const int size : kSizes) {
    for (int seed = 0; seed < kSeedCount; ++seed) {
      SCOPED_TRACE(testing::Message() << "size " << size << " seed " << seed);
      RandomStream random(seed);
      check(size, random);
    }
  }
}

TEST(MazeTest, NewMazeIsAllWall) { EXPECT_THAT(Drawn(Maze(3)), ElementsAre("###", "###", "###")); }

TEST(MazeTest, ExactlyOneWayJoinsTheRoomsOfAPlainMaze) {
  ForManyMazes([](int size, RandomStream& random) {
    Maze maze(size);
    maze.MakePlain(random);
    const std::vector<int> open = CellsOfKind(maze, kEmptyKind);
    const size_t side_rooms = static_cast<size_t>(size + 1) / 2;
    EXPECT_EQ(open.size(), 2 * side_rooms * side_rooms - 1);
    EXPECT_EQ(Reachable(maze, 0, 0).size(), open.size());
  });
}

TEST(MazeTest, PlainMazeTakesOneDrawForEachPartition) {
  for (const auto& [size, partitions] : {std::pair{11, 60U}, {13, 84U}, {19, 180U}}) {
    RandomStream random(5);
    Maze(size).MakePlain(random);
    EXPECT_EQ(random.draws(), partitions) << size;
  }
}

TEST(MazeTest, OpenCellsOfAPlainMazeAreListedOnce) {
  ForManyMazes([](int size, RandomStream& random) {
    Maze maze(size);
    maze.MakePlain(random);
    EXPECT_THAT(maze.open_cells(), UnorderedElementsAreArray(CellsOfKind(maze, kEmptyKind)));
  });
}

TEST(MazeTest, MakingAnewForgetsTheMazeBefore) {
  Maze maze(7);
  RandomStream random(1);
  maze.MakeWithDoors(random, 2);
  random.Seed(2);
  maze.MakePlain(random);
  random.Seed(2);
  Maze fresh(7);
  fresh.MakePlain(random);
  EXPECT_EQ(Drawn(maze), Drawn(fresh));
  EXPECT_EQ(maze.open_cells(), fresh.open_cells());
}

TEST(MazeTest, LastColumnAndRowOfAnEvenSizeStayWall) {
  RandomStream random(3);
  Maze maze(4);
  maze.MakePlain(random);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(maze.At(3, i), kWallKind);
    EXPECT_EQ(maze.At(i, 3), kWallKind);
  }
}

TEST(MazeTest, OneRoomAloneIsNeitherWallNorOpen) {
  RandomStream random(3);
  Maze maze(1);
  maze.MakePlain(random);
  EXPECT_EQ(maze.At(0, 0), 0);
  EXPECT_EQ(random.draws(), 0U);
}

TEST(MazeTest, DeadEndsAreOpened) {
  ForManyMazes([](int size, RandomStream& random) {
    Maze maze(size);
    maze.MakeWithoutDeadEnds(random);
    for (const int cell : CellsOfKind(maze, kEmptyKind)) {
      int ways = 0;
      for (const int next : Beside(maze, cell)) {
        ways += KindOf(maze, next) == kEmptyKind ? 1 : 0;
      }
      EXPECT_GE(ways, 2) << cell;
    }
  });
}

TEST(MazeTest, EachDeadEndThatIsOpenedTakesOneDraw) {
  ForManyMazes([](int size, RandomStream& random) {
    RandomStream same = random;
    Maze plain(size);
    plain.MakePlain(same);
    Maze maze(size);
    maze.MakeWithoutDeadEnds(random);
    const size_t opened =
        CellsOfKind(maze, kEmptyKind).size() - CellsOfKind(plain, kEmptyKind).size();
    EXPECT_EQ(random.draws() - same.draws(), opened);
    EXPECT_EQ(maze.open_cells(), plain.open_cells());
  });
}

TEST(MazeTest, MazeWithoutDeadEndsIsAsInChaser) {
  RandomStream random = StreamOfLevel(1000, 4);  // easy mode
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

TEST(MazeTest, EachDoorHasItsKey) {
  ForManyMazes([](int size, RandomStream& random) {
    Maze maze(size);
    const int doors = maze.MakeWithDoors(random, 3);
    EXPECT_THAT(doors, AllOf(Ge(0), Le(3)));
    EXPECT_EQ(CellsOfKind(maze, kMazeStartKind).size(), 1U);
    EXPECT_EQ(CellsOfKind(maze, kExitKind).size(), 1U);
    for (int i = 0; i < 3; ++i) {
      const size_t expected = i < doors ? 1 : 0;
      EXPECT_EQ(CellsOfKind(maze, kMazeDoorKind + i).size(), expected);
      EXPECT_EQ(CellsOfKind(maze, kMazeKeyKind + i).size(), expected);
    }
  });
}

// Doors open one after the other: what door i opens holds the key of door i + 1, or the exit.
TEST(MazeTest, KeysAndExitLieJustBehindTheDoorBefore) {
  ForManyMazes([](int size, RandomStream& random) {
    Maze maze(size);
    const int doors = maze.MakeWithDoors(random, 3);
    const int start = CellsOfKind(maze, kMazeStartKind)[0];
    for (int i = 0; i <= doors; ++i) {
      const int kind = i < doors ? kMazeKeyKind + i : kExitKind;
      const int place = CellsOfKind(maze, kind)[0];
      EXPECT_EQ(Reachable(maze, start, i).count(place), 1U) << i;
      if (i > 0) {
        EXPECT_EQ(Reachable(maze, start, i - 1).count(place), 0U) << i;
      }
    }
  });
}

TEST(MazeTest, DoorsStandInForksAndNotBesideTheStart) {
  ForManyMazes([](int size, RandomStream& random) {
    RandomStream same = random;
    Maze plain(size);
    plain.MakePlain(same);
    Maze maze(size);
    const int doors = maze.MakeWithDoors(random, 3);
    const std::vector<int> around_start = Beside(maze, CellsOfKind(maze, kMazeStartKind)[0]);
    for (int i = 0; i < doors; ++i) {
      const int door = CellsOfKind(maze, kMazeDoorKind + i)[0];
      int ways = 0;
      for (const int next : Beside(plain, door)) {
        ways += KindOf(plain, next) == kEmptyKind ? 1 : 0;
      }
      EXPECT_GT(ways, 2);
      EXPECT_EQ(std::count(around_start.begin(), around_start.end(), door), 0);
    }
  });
}

// A maze of four rooms has no fork.
TEST(MazeTest, WithTooFewForksThereAreFewerDoorsAndNoDrawForThem) {
  RandomStream random(4);
  Maze maze(3);
  EXPECT_EQ(maze.MakeWithDoors(random, 2), 0);
  const unsigned partitions = 4;
  const unsigned start_and_exit = 2;
  EXPECT_EQ(random.draws(), partitions + start_and_exit);
}

TEST(MazeTest, MazeWithDoorsIsAsInHeist) {
  RandomStream random = StreamOfLevel(1001, 6);  // hard mode
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

TEST(MazeTest, ObjectsLieInDifferentOpenCellsButTheCorner) {
  ForManyMazes([](int size, RandomStream& random) {
    Maze maze(size);
    maze.MakePlain(random);
    const std::vector<int> open = CellsOfKind(maze, kEmptyKind);
    constexpr int kObjectCount = 5;
    maze.PlaceObjects(random, kObjectCount, kObjectKind);
    EXPECT_EQ(maze.At(0, 0), kEmptyKind);
    for (int i = 0; i < kObjectCount; ++i) {
      const std::vector<int> places = CellsOfKind(maze, kObjectKind + i);
      ASSERT_EQ(places.size(), 1U) << i;
      EXPECT_EQ(std::count(open.begin(), open.end(), places[0]), 1) << i;
    }
  });
}

}  // namespace
}  // namespace procgen
