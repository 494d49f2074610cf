#ifndef ENVCORE_WORLD_PLACING_H_
#define ENVCORE_WORLD_PLACING_H_

#include "envcore/random/random_stream.h"
#include "envcore/world/entity.h"
#include "envcore/world/world.h"

namespace procgen {

// A box in the world: left edge, bottom edge and size, in cells.
struct Box {
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
};

enum class CollisionCheck { kAll, kAgentOnly };

// Draws a center in [low, high] for an entity of half-size `radius`. If it does not fit, returns
// the middle without a draw.
float DrawCenter(RandomStream& random, float low, float high, float radius);

// Adds an entity of `kind` at rest, at a drawn position in `box`. It overlaps neither the agent
// nor, with kAll, any entity without avoids_collisions. After 100 attempts it stays at the last
// position. Returns the entity.
Entity& SpawnInBox(World& world, RandomStream& random, int kind, float rx, float ry, const Box& box,
                   CollisionCheck check = CollisionCheck::kAll);
// Adds a square entity of `kind` at rest at the center of the cell. Takes no draw and tests no
// overlap.
Entity& SpawnAtCell(World& world, int kind, float radius, int cell_index);
// Adds a square entity of `kind` at the center of `parent`, at rest or with the parent's velocity.
Entity& SpawnChild(World& world, int kind, float radius, const Entity& parent, bool keeps_velocity);
// Adds a puff of dust at the feet of `parent`, which rises slowly, grows, fades and expires.
// Returns the entity.
Entity& SpawnDust(World& world, const Entity& parent);

// Whether `entity`, which is not in the world yet, overlaps any entity in it.
bool OverlapsAnything(const World& world, const Entity& entity);

// Draws positions for the agent, anywhere in the world, until it overlaps no entity; at most 100.
void PlaceAgentAtRandom(World& world, RandomStream& random);

// The distance between the centers, in cells.
float Distance(const Entity& a, const Entity& b);

}  // namespace procgen

#endif  // ENVCORE_WORLD_PLACING_H_
