#ifndef ENVCORE_WORLD_WORLD_H_
#define ENVCORE_WORLD_WORLD_H_

#include <cstdint>
#include <vector>

#include "envcore/world/entity.h"
#include "envcore/world/grid.h"
#include "envcore/world/kinds.h"

namespace procgen {

// The direction that the action requests in a step. A game may change it before anything moves.
struct Controls {
  float horizontal = 0;  // -1 left, 1 right
  float vertical = 0;    // -1 down, 1 up
  float turn = 0;
};

// A grid and its entities. entities[0] is always the agent; new entities are appended. A reference
// to an entity is valid until the next one is added.
struct World {
  Grid grid;
  std::vector<Entity> entities;
  int out_of_bounds_kind = kOutsideKind;
  bool whole_cell_motion = false;  // the agent moves zero or one cell per step, without velocity
  int32_t shared_random = 0;       // the step's shared random integer
  Controls controls;

  Entity& agent() { return entities[0]; }
  const Entity& agent() const { return entities[0]; }

  // The kind of cell (x, y), or out_of_bounds_kind outside the grid.
  int CellAt(int x, int y) const {
    return grid.Contains(x, y) ? grid.At(x, y) : out_of_bounds_kind;
  }
  // The kind of the cell that contains the point (x, y).
  int CellAtPoint(float x, float y) const {
    return x < 0 || y < 0 ? out_of_bounds_kind : CellAt(static_cast<int>(x), static_cast<int>(y));
  }
  // Whether the box is completely outside the world.
  bool IsOutside(const Entity& entity) const {
    return entity.x + entity.rx < 0 || entity.y + entity.ry < 0 ||
           entity.x - entity.rx > static_cast<float>(grid.width()) ||
           entity.y - entity.ry > static_cast<float>(grid.height());
  }
};

}  // namespace procgen

#endif  // ENVCORE_WORLD_WORLD_H_
