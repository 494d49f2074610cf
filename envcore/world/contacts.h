#ifndef ENVCORE_WORLD_CONTACTS_H_
#define ENVCORE_WORLD_CONTACTS_H_

#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// Finds contacts and calls the rules for them, entity by entity from last to first: contact with
// the agent, with other entities, with cells. Entities that the rules add meanwhile can be touched
// but are not visited themselves.
void MeetAll(World& world, Rules& rules);

// Removes, from last to first, every entity that is marked, or outside the world with auto_remove
// set. The agent is never removed: when it leaves the world, the level has ended.
void RemoveGone(World& world);

}  // namespace procgen

#endif  // ENVCORE_WORLD_CONTACTS_H_
