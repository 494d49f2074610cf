#ifndef ENVCORE_WORLD_SUPPORT_H_
#define ENVCORE_WORLD_SUPPORT_H_

#include "envcore/world/entity.h"
#include "envcore/world/world.h"

namespace procgen {

// Whether `entity` stands on a cell of a kind that `carries` accepts: whether such a cell is just
// below the left or the right end of its feet. Its velocity does not matter.
bool StandsOn(const World& world, const Entity& entity, bool (*carries)(int kind));

}  // namespace procgen

#endif  // ENVCORE_WORLD_SUPPORT_H_
