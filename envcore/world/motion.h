#ifndef ENVCORE_WORLD_MOTION_H_
#define ENVCORE_WORLD_MOTION_H_

#include "envcore/world/entity.h"
#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// Smart motion: moves `entity`, one of `world`'s, by its velocity through cells and entities
// without tunnelling. The way is cut into sub-steps, each axis apart; what blocks stops it at its
// edge, what reflects turns it back. Reduces the velocity by the share of the way that was blocked.
// The rules must not add entities meanwhile.
void MoveSmart(World& world, Rules& rules, Entity& entity);

}  // namespace procgen

#endif  // ENVCORE_WORLD_MOTION_H_
