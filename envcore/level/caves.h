#ifndef ENVCORE_LEVEL_CAVES_H_
#define ENVCORE_LEVEL_CAVES_H_

#include <cstdint>
#include <vector>

#include "envcore/world/grid.h"

namespace procgen {

// Cave generation on a grid of open cells (kEmptyKind) and walls (kWallKind): smooth noise into
// caverns, keep the largest one, find a path through it, keep the cells near that path. These
// functions take no draws. A set of cells is a list of cell indices in ascending order.

// One round of a cellular automaton: each cell becomes wall if most cells of its 3 x 3 block are
// wall, else open. All cells change at once. Cells outside the grid count as wall.
void SmoothCave(Grid& grid);

// The set of open cells that are connected to `cell` by horizontal and vertical steps. Contains
// `cell` itself only if it has an open neighbor.
std::vector<int32_t> RoomOf(const Grid& grid, int cell);
// The largest room of the grid; of equal ones, the one with the smallest cell index. Empty if no
// two open cells are neighbors.
std::vector<int32_t> BestRoom(const Grid& grid);

// A shortest path over open cells from `from` to `to`, both included. Of several, the one that a
// breadth-first search finds in the order left, below, above, right. Empty if `from` is not open.
// REQUIRES: `to` is reachable.
std::vector<int32_t> FindPath(const Grid& grid, int from, int to);

// `cells`, and all open cells that are reachable from its open cells in at most `rounds` steps,
// diagonal steps included.
std::vector<int32_t> Widened(const Grid& grid, const std::vector<int32_t>& cells, int rounds);

}  // namespace procgen

#endif  // ENVCORE_LEVEL_CAVES_H_
