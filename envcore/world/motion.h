#ifndef ENVCORE_WORLD_MOTION_H_
#define ENVCORE_WORLD_MOTION_H_

#include "envcore/world/entity.h"
#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// Smart motion: moves `entity`, which must be in `world`, by its velocity and stops it at cells and
// entities, without tunnelling. The path is divided into sub-steps, per axis. What blocks stops the
// entity at its edge; what reflects reverses it. The velocity is reduced by the fraction of the
// path that was blocked. The rules must not add entities meanwhile.
void MoveSmart(World& world, Rules& rules, Entity& entity);

}  // namespace procgen

#endif  // ENVCORE_WORLD_MOTION_H_
