#ifndef ENVCORE_WORLD_CONTACTS_H_
#define ENVCORE_WORLD_CONTACTS_H_

#include "envcore/world/rules.h"
#include "envcore/world/world.h"

namespace procgen {

// Finds what touches what and asks the rules what follows, for the entities from last to first:
// contact with the agent, with other entities, with cells. Entities that the rules add are partners
// but are not visited themselves.
void MeetAll(World& world, Rules& rules);

// Removes, from last to first, every entity that is marked or is out of the world (unless it may
// stay there). The agent stays: an agent out of the world has ended its episode.
void RemoveGone(World& world);

}  // namespace procgen

#endif  // ENVCORE_WORLD_CONTACTS_H_
