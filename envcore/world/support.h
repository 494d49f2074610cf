#ifndef ENVCORE_WORLD_SUPPORT_H_
#define ENVCORE_WORLD_SUPPORT_H_

#include "envcore/world/entity.h"
#include "envcore/world/world.h"

namespace procgen {

// Whether `entity` stands on a cell whose kind `carries` accepts: such a cell is just below the
// left or the right end of its bottom edge. The velocity does not matter.
bool StandsOn(const World& world, const Entity& entity, bool (*carries)(int kind));

}  // namespace procgen

#endif  // ENVCORE_WORLD_SUPPORT_H_
