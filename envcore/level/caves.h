#ifndef ENVCORE_LEVEL_CAVES_H_
#define ENVCORE_LEVEL_CAVES_H_

#include <cstdint>
#include <vector>

#include "envcore/world/grid.h"

namespace procgen {

// Tools that make caves of open cells (kEmptyKind) in wall (kWallKind): smooth noise into caverns,
// keep the largest one, find a way through it, keep what lies near that way. They take no draws.
// Sets of cells are lists of cell indices in ascending order.

// One round of a cellular automaton: each cell becomes wall when wall has the majority in the 3 x 3
// block around it, else open; all at once. What lies outside of the grid counts as wall.
void SmoothCave(Grid& grid);

// The set of all open cells that can be reached from `cell` by steps to the side. `cell` itself
// belongs to it only if it has an open neighbor.
std::vector<int32_t> RoomOf(const Grid& grid, int cell);
// The largest room of the grid; among equals the one with the smallest cell index. Empty when no
// two open cells are neighbors.
std::vector<int32_t> BestRoom(const Grid& grid);

// A shortest path over open cells, from `from` to `to`, both included; of several the one that a
// search finds which looks left, below, above, right. Empty if `from` is not open. REQUIRES: `to`
// can be reached.
std::vector<int32_t> FindPath(const Grid& grid, int from, int to);

// `cells`, a set, and all open cells that can be reached from its open ones by at most `rounds`
// steps, diagonal ones too.
std::vector<int32_t> Widened(const Grid& grid, const std::vector<int32_t>& cells, int rounds);

}  // namespace procgen

#endif  // ENVCORE_LEVEL_CAVES_H_
