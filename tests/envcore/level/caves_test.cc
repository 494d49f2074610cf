// Worlds are drawn as text, top row first: # is wall, every other character is open. An x marks the
// cells of a set.

#include "envcore/level/caves.h"

#include <algorithm>
#include <string>

#include "envcore/world/kinds.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Rows = std::vector<std::string>;

Grid MakeGrid(const Rows& rows) {
  const auto width = static_cast<int>(rows.front().size());
  const auto height = static_cast<int>(rows.size());
  Grid grid;
  grid.Reset(width, height, kEmptyKind);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const char cell = rows[static_cast<size_t>(height - 1 - y)][static_cast<size_t>(x)];
      grid.Set(x, y, cell == '#' ? kWallKind : kEmptyKind);
    }
  }
  return grid;
}

Rows Drawn(const Grid& grid, const std::vector<int32_t>& cells = {}) {
  Rows rows(static_cast<size_t>(grid.height()));
  for (int y = 0; y < grid.height(); ++y) {
    for (int x = 0; x < grid.width(); ++x) {
      const bool chosen = std::binary_search(cells.begin(), cells.end(), grid.IndexOf(x, y));
      const char open = chosen ? 'x' : '.';
      rows[static_cast<size_t>(grid.height() - 1 - y)] += grid.At(x, y) == kWallKind ? '#' : open;
    }
  }
  return rows;
}

// clang-format off: drawings stay drawings

TEST(RoomOfTest, AnIsolatedCellHasAnEmptyRoom) {
  EXPECT_THAT(RoomOf(MakeGrid({"###", "#.#", "###"}), 4), IsEmpty());
}

TEST(BestRoomTest, TiesGoToTheSmallestIndex) {
  const Grid grid = MakeGrid({"..#..", "..#.."});
  EXPECT_THAT(Drawn(grid, BestRoom(grid)), ElementsAre("xx#..", "xx#.."));
}

TEST(FindPathTest, PathFromAWallIsEmpty) {
  EXPECT_THAT(FindPath(MakeGrid({"#."}), 0, 1), IsEmpty());
}

TEST(WidenedTest, DoesNotExtendFromCellsThatAreNotOpen) {
  EXPECT_THAT(Widened(MakeGrid({"#.."}), {0}, 1), ElementsAre(0));
}

}  // namespace
}  // namespace procgen
