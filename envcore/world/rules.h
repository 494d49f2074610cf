#ifndef ENVCORE_WORLD_RULES_H_
#define ENVCORE_WORLD_RULES_H_

#include "envcore/world/entity.h"

namespace procgen {

// The direction of an elementary move. A move by (0, 0) is vertical.
enum class Axis { kHorizontal, kVertical };

// What a game says when things in its world move and meet. The order in which the engine asks is
// part of the behaviour, for an answer may have side effects. What a game answers to Blocks,
// Reflects and EntityBlocks follows from what it is asked about, so asking again changes nothing
// more.
class Rules {
 public:
  virtual ~Rules() = default;

  // Whether a cell of `kind` stops `mover` on this axis.
  virtual bool Blocks(const Entity& mover, int kind, Axis axis) = 0;
  // Whether `mover` bounces off a cell or entity of `kind`.
  virtual bool Reflects(const Entity& mover, int kind) = 0;
  // Whether `other` stops `mover` on this axis: by default as a cell of its kind does.
  virtual bool EntityBlocks(const Entity& mover, const Entity& other, Axis axis) {
    return Blocks(mover, other.kind, axis);
  }

  // A cell has just stopped `mover` in its motion on this axis; what this makes of its velocity
  // holds for the rest of the way. By default nothing.
  virtual void OnStoppedByCell(Entity& /*mover*/, Axis /*axis*/) {}

  // The agent touches `other` (which may be marked already).
  virtual void OnAgentContact(Entity& other) = 0;
  // `self`, which takes part in entity contacts, touches `other`; neither is marked.
  virtual void OnEntityContact(Entity& self, Entity& other) = 0;
  // The smart entity touches cell (x, y) of `kind`, which is not empty and may lie outside of the
  // world.
  virtual void OnCellContact(Entity& entity, int kind, int x, int y) = 0;
};

}  // namespace procgen

#endif  // ENVCORE_WORLD_RULES_H_
