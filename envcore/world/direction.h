#ifndef ENVCORE_WORLD_DIRECTION_H_
#define ENVCORE_WORLD_DIRECTION_H_

#include "envcore/world/entity.h"

namespace procgen {

// The rules' pi, in f32. A positive rotation is clockwise on the screen.
inline constexpr float kPi = 3.14159274F;
inline constexpr float kHalfPi = 1.57079637F;

// Rotates `entity` so that art that faces right points along (dx, dy), plus `offset` radians. Does
// nothing if dx and dy are 0.
void TurnTo(Entity& entity, float dx, float dy, float offset);

}  // namespace procgen

#endif  // ENVCORE_WORLD_DIRECTION_H_
