#ifndef ENVCORE_WORLD_RULES_H_
#define ENVCORE_WORLD_RULES_H_

#include "envcore/world/entity.h"

namespace procgen {

// The direction of an elementary move. A move by (0, 0) is vertical.
enum class Axis { kHorizontal, kVertical };

// The callbacks of a game for motion and contacts. The order of the calls is part of the behavior,
// because a callback may have side effects. Blocks, Reflects and EntityBlocks depend only on their
// arguments and the state, so repeated calls have no further effect.
class Rules {
 public:
  virtual ~Rules() = default;

  // Whether a cell of `kind` stops `mover` on this axis.
  virtual bool Blocks(const Entity& mover, int kind, Axis axis) = 0;
  // Whether `mover` bounces off a cell or entity of `kind`.
  virtual bool Reflects(const Entity& mover, int kind) = 0;
  // Whether `other`, which is no effect, stops `mover` on this axis. Default: like a cell of its
  // kind.
  virtual bool EntityBlocks(const Entity& mover, const Entity& other, Axis axis) {
    return Blocks(mover, other.kind, axis);
  }

  // Called when a cell has stopped `mover` on this axis. A velocity that is set here applies to the
  // rest of the motion. Default: does nothing.
  virtual void OnStoppedByCell(Entity& /*mover*/, Axis /*axis*/) {}

  // Called when the agent touches `other`, which may already be marked.
  virtual void OnAgentContact(Entity& other) = 0;
  // Called when `self`, which has meets_entities, touches `other`. Neither is marked.
  virtual void OnEntityContact(Entity& self, Entity& other) = 0;
  // Called when a smart entity touches cell (x, y) of `kind`. The cell is not empty and may be
  // outside the world.
  virtual void OnCellContact(Entity& entity, int kind, int x, int y) = 0;
};

}  // namespace procgen

#endif  // ENVCORE_WORLD_RULES_H_
