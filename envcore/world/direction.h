#ifndef ENVCORE_WORLD_DIRECTION_H_
#define ENVCORE_WORLD_DIRECTION_H_

#include "envcore/world/entity.h"

namespace procgen {

// The rules' pi, in f32. On the screen a positive rotation turns clockwise.
inline constexpr float kPi = 3.14159274F;
inline constexpr float kHalfPi = 1.57079637F;

// Turns `entity` so that art which faces right looks along (dx, dy), and then by `offset` radians
// more. Nothing if both are 0.
void TurnTo(Entity& entity, float dx, float dy, float offset);

}  // namespace procgen

#endif  // ENVCORE_WORLD_DIRECTION_H_
