#ifndef ENVCORE_GAMES_GAME_OBJECTS_H_
#define ENVCORE_GAMES_GAME_OBJECTS_H_

#include <cstdint>

#include "absl/types/span.h"
#include "envcore/games/game_spec.h"
#include "envcore/world/world.h"

namespace procgen {

// An entity, or a cell of a goal kind, as ten numbers. Unused rows have kind -1 and else zeros.
struct ObjectRow {
  float kind = -1;  // see GameSpec
  float theme = 0;  // index of its image, such as the color of a key
  float x = 0;      // center, in cells from the bottom left of the level
  float y = 0;
  float vx = 0;  // cells per step
  float vy = 0;
  float rx = 0;  // half-sizes, in cells
  float ry = 0;
  float rotation = 0;  // radians, clockwise on the screen
  float health = 0;    // as the game defines it; 1: unused
};

// Fills `rows` with the objects of a world and returns their number, which can exceed the number of
// rows. The order is: the agent; the goals, entities before cells; all other entities. Entities
// with screen coordinates, such as displays of taken keys, are left out.
int32_t ReadObjects(const World& world, absl::Span<const KindName> kinds,
                    absl::Span<ObjectRow> rows);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_OBJECTS_H_
