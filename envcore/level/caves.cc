#include "envcore/level/caves.h"

#include <algorithm>
#include <array>
#include <utility>

#include "envcore/world/kinds.h"

namespace procgen {
namespace {

constexpr int kMajority = 5;  // of the nine cells of a block

struct Offset {
  int x;
  int y;
};

constexpr std::array<Offset, 4> kSides = {{{-1, 0}, {0, -1}, {0, 1}, {1, 0}}};
constexpr std::array<Offset, 9> kBlock = {
    {{-1, -1}, {-1, 0}, {-1, 1}, {0, -1}, {0, 0}, {0, 1}, {1, -1}, {1, 0}, {1, 1}}};

bool IsWallOrOutside(const Grid& grid, int x, int y) {
  return !grid.Contains(x, y) || grid.At(x, y) == kWallKind;
}

// The open cell at an offset from `cell`; kNoCell if it is not open or is outside the grid.
int OpenCellAt(const Grid& grid, int cell, Offset offset) {
  const int x = cell % grid.width() + offset.x;
  const int y = cell / grid.width() + offset.y;
  return grid.Contains(x, y) && grid.At(x, y) == kEmptyKind ? grid.IndexOf(x, y) : kNoCell;
}

// A set of cells of one grid.
class CellSet {
 public:
  explicit CellSet(const Grid& grid) : contains_(static_cast<size_t>(grid.size()), false) {}

  bool Contains(int cell) const { return contains_[static_cast<size_t>(cell)]; }
  // Returns whether the cell is new.
  bool Add(int cell) {
    const bool is_new = !Contains(cell);
    contains_[static_cast<size_t>(cell)] = true;
    return is_new;
  }

 private:
  std::vector<bool> contains_;
};

}  // namespace

void SmoothCave(Grid& grid) {
  const Grid before = grid;
  for (int cell = 0; cell < grid.size(); ++cell) {
    const int x = cell % grid.width();
    const int y = cell / grid.width();
    const auto walls = std::count_if(kBlock.begin(), kBlock.end(), [&before, x, y](Offset offset) {
      return IsWallOrOutside(before, x + offset.x, y + offset.y);
    });
    grid.Set(cell, walls >= kMajority ? kWallKind : kEmptyKind);
  }
}

std::vector<int32_t> RoomOf(const Grid& grid, int cell) {
  std::vector<int32_t> room;
  if (grid.At(cell) != kEmptyKind) {
    return room;
  }
  CellSet found(grid);
  std::vector<int32_t> front = {cell};
  while (!front.empty()) {
    const int center = front.back();
    front.pop_back();
    for (const Offset side : kSides) {
      const int neighbor = OpenCellAt(grid, center, side);
      if (neighbor != kNoCell && found.Add(neighbor)) {
        room.push_back(neighbor);
        front.push_back(neighbor);
      }
    }
  }
  std::sort(room.begin(), room.end());
  return room;
}

std::vector<int32_t> BestRoom(const Grid& grid) {
  std::vector<int32_t> best;
  CellSet visited(grid);
  for (int cell = 0; cell < grid.size(); ++cell) {
    if (grid.At(cell) != kEmptyKind || visited.Contains(cell)) {
      continue;
    }
    std::vector<int32_t> room = RoomOf(grid, cell);
    for (const int32_t member : room) {
      visited.Add(member);
    }
    if (room.size() > best.size()) {
      best = std::move(room);
    }
  }
  return best;
}

std::vector<int32_t> FindPath(const Grid& grid, int from, int to) {
  if (grid.At(from) != kEmptyKind) {
    return {};
  }
  std::vector<int32_t> came_from(static_cast<size_t>(grid.size()), kNoCell);
  CellSet discovered(grid);
  discovered.Add(from);
  std::vector<int32_t> queue = {from};
  for (size_t next = 0; next < queue.size() && queue[next] != to; ++next) {
    for (const Offset side : kSides) {
      const int neighbor = OpenCellAt(grid, queue[next], side);
      if (neighbor != kNoCell && discovered.Add(neighbor)) {
        came_from[static_cast<size_t>(neighbor)] = queue[next];
        queue.push_back(neighbor);
      }
    }
  }
  std::vector<int32_t> path;
  for (int cell = to; cell != kNoCell; cell = came_from[static_cast<size_t>(cell)]) {
    path.push_back(cell);
  }
  std::reverse(path.begin(), path.end());
  return path;
}

std::vector<int32_t> Widened(const Grid& grid, const std::vector<int32_t>& cells, int rounds) {
  std::vector<int32_t> widened = cells;
  CellSet added(grid);
  for (const int32_t cell : cells) {
    added.Add(cell);
  }
  size_t front = 0;  // index in `widened` at which the cells of the last round begin
  for (int round = 0; round < rounds; ++round) {
    const size_t front_end = widened.size();
    for (; front < front_end; ++front) {
      if (grid.At(widened[front]) != kEmptyKind) {
        continue;
      }
      for (const Offset offset : kBlock) {
        const int neighbor = OpenCellAt(grid, widened[front], offset);
        if (neighbor != kNoCell && added.Add(neighbor)) {
          widened.push_back(neighbor);
        }
      }
    }
  }
  std::sort(widened.begin(), widened.end());
  return widened;
}

}  // namespace procgen
