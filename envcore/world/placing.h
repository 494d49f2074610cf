#ifndef ENVCORE_WORLD_PLACING_H_
#define ENVCORE_WORLD_PLACING_H_

#include "envcore/random/random_stream.h"
#include "envcore/world/entity.h"
#include "envcore/world/world.h"

namespace procgen {

// A box in the world: left edge, bottom edge, size, in cells.
struct Box {
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
};

enum class CollisionCheck { kAll, kAgentOnly };

// Draws a centre in [low, high] for something with half-size `radius`; without a draw the middle,
// when it does not fit.
float DrawCenter(RandomStream& random, float low, float high, float radius);

// Adds an entity of `kind` at rest, at a drawn place in `box` where it overlaps neither the agent
// nor (kAll) anything that does not avoid collisions; after 100 attempts it stays where it is.
// Returns it.
Entity& SpawnInBox(World& world, RandomStream& random, int kind, float rx, float ry, const Box& box,
                   CollisionCheck check = CollisionCheck::kAll);
// Adds a square entity of `kind` at rest in the middle of the cell, without a draw or test.
Entity& SpawnAtCell(World& world, int kind, float radius, int cell_index);
// Adds a square entity of `kind` at the centre of `parent`, at rest or with the parent's velocity.
Entity& SpawnChild(World& world, int kind, float radius, const Entity& parent, bool keeps_velocity);
// Adds a puff of dust at the feet of `parent`: it rises slowly, grows, fades and soon is gone.
// Returns it.
Entity& SpawnDust(World& world, const Entity& parent);

// Whether `entity`, which is not in the world yet, overlaps anything in it.
bool OverlapsAnything(const World& world, const Entity& entity);

// Draws a new place for the agent, anywhere in the world, until it overlaps nothing; at most 100
// times.
void PlaceAgentAnew(World& world, RandomStream& random);

// The distance of two centres, in cells.
float Distance(const Entity& a, const Entity& b);

}  // namespace procgen

#endif  // ENVCORE_WORLD_PLACING_H_
