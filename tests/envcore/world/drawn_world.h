#ifndef TESTS_ENVCORE_WORLD_DRAWN_WORLD_H_
#define TESTS_ENVCORE_WORLD_DRAWN_WORLD_H_

#include <map>
#include <string>
#include <vector>

#include "envcore/world/kinds.h"
#include "envcore/world/world.h"

namespace procgen {

// A world as text: rows from the top down, one character per cell, so y points up.
using Drawing = std::vector<std::string>;
// The meaning of each character: a kind of cell.
using Legend = std::map<char, int>;

inline const Legend& WallLegend() {
  static const Legend legend = {{'.', kEmptyKind}, {'#', kWallKind}};
  return legend;
}

// Fills `grid` with the drawn cells; characters that are not in the legend become empty cells.
inline void DrawGrid(const Drawing& rows, const Legend& legend, Grid* grid) {
  const auto height = static_cast<int>(rows.size());
  grid->Reset(static_cast<int>(rows.front().size()), height, kEmptyKind);
  for (int y = 0; y < height; ++y) {
    const std::string& row = rows[static_cast<size_t>(height - 1 - y)];
    for (int x = 0; x < grid->width(); ++x) {
      const auto found = legend.find(row[static_cast<size_t>(x)]);
      grid->Set(x, y, found == legend.end() ? kEmptyKind : found->second);
    }
  }
}

// The drawing of a grid; '?' for kinds that are not in the legend.
inline Drawing Drawn(const Grid& grid, const Legend& legend) {
  Drawing rows(static_cast<size_t>(grid.height()),
               std::string(static_cast<size_t>(grid.width()), '?'));
  for (int y = 0; y < grid.height(); ++y) {
    for (int x = 0; x < grid.width(); ++x) {
      for (const auto& [character, kind] : legend) {
        if (kind == grid.At(x, y)) {
          rows[static_cast<size_t>(grid.height() - 1 - y)][static_cast<size_t>(x)] = character;
        }
      }
    }
  }
  return rows;
}

// A world of walls and empty cells with an agent, smart and at rest, of half-sizes `radius`.
inline World DrawWorld(const Drawing& rows, float agent_x, float agent_y, float radius = 0.4F) {
  World world;
  DrawGrid(rows, WallLegend(), &world.grid);
  Entity& agent =
      world.entities.emplace_back(Entity::Make(kAgentKind, agent_x, agent_y, 0, 0, radius, radius));
  agent.smart = true;
  return world;
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_WORLD_DRAWN_WORLD_H_
