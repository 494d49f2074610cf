#ifndef ENVCORE_LEVEL_MAZE_H_
#define ENVCORE_LEVEL_MAZE_H_

#include <cstdint>
#include <vector>

#include "envcore/random/random_stream.h"
#include "envcore/world/grid.h"

namespace procgen {

// Cell kinds of a maze besides walls (kWallKind) and open cells (kEmptyKind).
inline constexpr int kMazeStartKind = 53;
inline constexpr int kMazeDoorKind = 201;  // door i: kMazeDoorKind + i
inline constexpr int kMazeKeyKind = 301;   // key of door i: kMazeKeyKind + i

// A square maze of size x size cells; cell (0, 0) is at the bottom left. Around it is a frame of
// wall one cell wide that is not part of the maze. Rooms are the cells with even x and y. In a
// plain maze exactly one path connects any two rooms.
class Maze {
 public:
  // All wall. REQUIRES: size >= 1; normally odd.
  explicit Maze(int size);

  // Makes a plain maze (a random spanning tree). Takes one draw per partition between two rooms.
  void MakePlain(RandomStream& random);
  // Makes a plain maze and opens a wall next to each dead end that has one. Takes one more draw for
  // each of these.
  void MakeWithoutDeadEnds(RandomStream& random);
  // Makes a plain maze with a start, at most `door_count` doors and an exit (kExitKind) behind the
  // last door. The key of each door is reachable before the door. Returns the number of doors.
  int MakeWithDoors(RandomStream& random, int door_count);
  // Places `count` objects, of kinds first_kind, first_kind + 1, ..., in different open cells of a
  // plain maze other than (0, 0).
  void PlaceObjects(RandomStream& random, int count, int first_kind);

  int size() const { return size_; }
  // The kind of maze cell (x, y). REQUIRES: both in [0, size).
  int At(int x, int y) const { return frame_.At(x + 1, y + 1); }
  // The cells that MakePlain opened, as y * size + x, in the order in which they were first opened.
  const std::vector<int32_t>& open_cells() const { return open_cells_; }

 private:
  void Open(int x, int y);

  int size_;
  Grid frame_;  // (size + 2) x (size + 2)
  std::vector<int32_t> open_cells_;
};

}  // namespace procgen

#endif  // ENVCORE_LEVEL_MAZE_H_
