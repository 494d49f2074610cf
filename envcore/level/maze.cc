#include "envcore/level/maze.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "envcore/world/kinds.h"

namespace procgen {
namespace {

constexpr int kUnnumberedDoorKind = 200;

// The partition between two rooms at distance 2; (x, y) is its cell.
struct Partition {
  int x;
  int y;
  bool between_columns;  // separates the rooms left and right of it, else those below and above
};

std::vector<Partition> ListPartitions(int size) {
  std::vector<Partition> partitions;
  for (int x = 1; x < size - 1; x += 2) {
    for (int y = 0; y < size; y += 2) {
      partitions.push_back({x, y, true});
    }
  }
  for (int x = 0; x < size; x += 2) {
    for (int y = 1; y < size - 1; y += 2) {
      partitions.push_back({x, y, false});
    }
  }
  return partitions;
}

// Union-find over the cells: which rooms are connected.
class Groups {
 public:
  explicit Groups(int cell_count) : parents_(static_cast<size_t>(cell_count)) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  int Find(int cell) {
    while (Parent(cell) != cell) {
      Parent(cell) = Parent(Parent(cell));
      cell = Parent(cell);
    }
    return cell;
  }
  void Join(int a, int b) { Parent(Find(a)) = Find(b); }

 private:
  int& Parent(int cell) { return parents_[static_cast<size_t>(cell)]; }

  std::vector<int> parents_;
};

// Left, below, above, right. REQUIRES: `cell` is not in the frame, or cells outside the grid are
// not used.
std::array<int, 4> Neighbors(const Grid& frame, int cell) {
  return {cell - 1, cell - frame.width(), cell + frame.width(), cell + 1};
}

bool IsInRing(const Grid& frame, int cell) {
  const int x = cell % frame.width();
  const int y = cell / frame.width();
  return x == 0 || y == 0 || x == frame.width() - 1 || y == frame.height() - 1;
}

int CountOpenNeighbors(const Grid& frame, int cell) {
  const std::array<int, 4> neighbors = Neighbors(frame, cell);
  return static_cast<int>(std::count_if(neighbors.begin(), neighbors.end(), [&frame](int neighbor) {
    return frame.At(neighbor) == kEmptyKind;
  }));
}

bool IsBesideDoor(const Grid& frame, int cell) {
  const std::array<int, 4> neighbors = Neighbors(frame, cell);
  return std::any_of(neighbors.begin(), neighbors.end(),
                     [&frame](int neighbor) { return frame.At(neighbor) == kUnnumberedDoorKind; });
}

// Explores open cells from known cells. Rooms behind closed doors stay unknown.
class Explorer {
 public:
  explicit Explorer(const Grid& frame)
      : frame_(frame), known_(static_cast<size_t>(frame.size()), false) {}

  void Learn(int cell) { known_[static_cast<size_t>(cell)] = true; }

  // Returns the first unnumbered door next to the known cells, then next to the open cells around
  // them, and so on outward, each round in index order. Returns kNoCell if there is none.
  int FindDoor() const {
    std::vector<bool> found = known_;
    std::vector<int> front = Listed(known_);
    while (!front.empty()) {
      std::vector<int> next;
      for (const int cell : front) {
        for (const int neighbor : Neighbors(frame_, cell)) {
          if (frame_.At(neighbor) == kEmptyKind && !found[static_cast<size_t>(neighbor)]) {
            found[static_cast<size_t>(neighbor)] = true;
            next.push_back(neighbor);
          }
        }
        for (const int neighbor : Neighbors(frame_, cell)) {
          if (frame_.At(neighbor) == kUnnumberedDoorKind) {
            return neighbor;
          }
        }
      }
      std::sort(next.begin(), next.end());
      front = std::move(next);
    }
    return kNoCell;
  }

  // Marks all reachable open cells as known and returns the new ones in index order.
  std::vector<int> Explore() {
    std::vector<int> front = Listed(known_);
    std::vector<int> fresh;
    while (!front.empty()) {
      const int cell = front.back();
      front.pop_back();
      for (const int neighbor : Neighbors(frame_, cell)) {
        if (frame_.At(neighbor) == kEmptyKind && !known_[static_cast<size_t>(neighbor)]) {
          Learn(neighbor);
          front.push_back(neighbor);
          fresh.push_back(neighbor);
        }
      }
    }
    std::sort(fresh.begin(), fresh.end());
    return fresh;
  }

 private:
  static std::vector<int> Listed(const std::vector<bool>& set) {
    std::vector<int> cells;
    for (size_t cell = 0; cell < set.size(); ++cell) {
      if (set[cell]) {
        cells.push_back(static_cast<int>(cell));
      }
    }
    return cells;
  }

  const Grid& frame_;
  std::vector<bool> known_;
};

}  // namespace

Maze::Maze(int size) : size_(size) { frame_.Reset(size + 2, size + 2, kWallKind); }

void Maze::Open(int x, int y) {
  if (At(x, y) != kEmptyKind) {
    frame_.Set(x + 1, y + 1, kEmptyKind);
    open_cells_.push_back(y * size_ + x);
  }
}

void Maze::MakePlain(RandomStream& random) {
  frame_.Reset(size_ + 2, size_ + 2, kWallKind);
  open_cells_.clear();
  // Only a maze of one cell keeps this kind: all others open the corner.
  frame_.Set(1, 1, 0);
  std::vector<Partition> partitions = ListPartitions(size_);
  Groups groups(size_ * size_);
  while (!partitions.empty()) {
    const int32_t index = random.Int(static_cast<int32_t>(partitions.size()));
    const Partition partition = partitions[static_cast<size_t>(index)];
    partitions.erase(partitions.begin() + index);
    const int dx = partition.between_columns ? 1 : 0;
    const int dy = partition.between_columns ? 0 : 1;
    const int first_room = (partition.y - dy) * size_ + partition.x - dx;
    const int second_room = (partition.y + dy) * size_ + partition.x + dx;
    if (groups.Find(first_room) != groups.Find(second_room)) {
      Open(partition.x - dx, partition.y - dy);
      Open(partition.x, partition.y);
      Open(partition.x + dx, partition.y + dy);
      groups.Join(first_room, second_room);
    }
  }
}

void Maze::MakeWithoutDeadEnds(RandomStream& random) {
  MakePlain(random);
  for (int cell = 0; cell < frame_.size(); ++cell) {
    if (frame_.At(cell) != kEmptyKind || CountOpenNeighbors(frame_, cell) != 1) {
      continue;
    }
    std::vector<int32_t> walls;
    for (const int neighbor : Neighbors(frame_, cell)) {
      if (frame_.At(neighbor) == kWallKind && !IsInRing(frame_, neighbor)) {
        walls.push_back(neighbor);
      }
    }
    if (!walls.empty()) {
      frame_.Set(random.OneOf(walls), kEmptyKind);
    }
  }
}

int Maze::MakeWithDoors(RandomStream& random, int door_count) {
  MakePlain(random);
  std::vector<int32_t> forks;
  for (int cell = 0; cell < frame_.size(); ++cell) {
    if (frame_.At(cell) == kEmptyKind && CountOpenNeighbors(frame_, cell) > 2) {
      forks.push_back(cell);
    }
  }
  const std::vector<int32_t> doors = random.NOf(forks, door_count);
  for (const int32_t door : doors) {
    frame_.Set(door, kUnnumberedDoorKind);
  }

  std::vector<int32_t> open;
  for (int cell = 0; cell < frame_.size(); ++cell) {
    if (frame_.At(cell) == kEmptyKind) {
      open.push_back(cell);
    }
  }
  int start = random.OneOf(open);
  while (IsBesideDoor(frame_, start)) {
    start = random.OneOf(open);
  }
  frame_.Set(start, kMazeStartKind);

  Explorer explorer(frame_);
  explorer.Learn(start);
  const auto taken = static_cast<int>(doors.size());
  for (int i = 0; i <= taken; ++i) {
    const int door = i < taken ? explorer.FindDoor() : kNoCell;
    if (door != kNoCell) {
      frame_.Set(door, kMazeDoorKind + i);
    }
    const std::vector<int32_t> fresh = explorer.Explore();
    frame_.Set(random.OneOf(fresh), i < taken ? kMazeKeyKind + i : kExitKind);
    if (door != kNoCell) {
      explorer.Learn(door);
    }
  }
  return taken;
}

void Maze::PlaceObjects(RandomStream& random, int count, int first_kind) {
  std::vector<bool> used(open_cells_.size(), false);
  for (int i = 0; i < count; ++i) {
    size_t index = 0;
    do {
      index = static_cast<size_t>(random.Int(static_cast<int32_t>(open_cells_.size())));
    } while (open_cells_[index] == 0 || used[index]);
    used[index] = true;
    const int cell = open_cells_[index];
    frame_.Set(cell % size_ + 1, cell / size_ + 1, first_kind + i);
  }
}

}  // namespace procgen
