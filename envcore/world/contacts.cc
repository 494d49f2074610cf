#include "envcore/world/contacts.h"

#include <algorithm>
#include <cstddef>

#include "envcore/world/kinds.h"

namespace procgen {
namespace {

constexpr float kCellMargin = 0.001F;  // cells; a box flush with a cell's edge does not touch it

void MeetEntities(World& world, Rules& rules, size_t index) {
  for (size_t i = world.entities.size(); i-- > 0;) {
    Entity& self = world.entities[index];
    Entity& other = world.entities[i];
    if (i != index && !self.marked && !other.marked && Overlap(self, other, self.contact_margin)) {
      rules.OnEntityContact(self, other);
    }
  }
}

void MeetCells(World& world, Rules& rules, size_t index) {
  const Entity& entity = world.entities[index];
  const float reach_x = entity.rx - kCellMargin;
  const float reach_y = entity.ry - kCellMargin;
  const int left = static_cast<int>(entity.x - reach_x);
  const int right = static_cast<int>(entity.x + reach_x);
  const int bottom = static_cast<int>(entity.y - reach_y);
  const int top = static_cast<int>(entity.y + reach_y);
  for (int x = left; x <= right; ++x) {
    for (int y = bottom; y <= top; ++y) {
      const int kind = world.CellAt(x, y);
      if (kind != kEmptyKind) {
        rules.OnCellContact(world.entities[index], kind, x, y);
      }
    }
  }
}

}  // namespace

void MeetAll(World& world, Rules& rules) {
  for (size_t i = world.entities.size(); i-- > 0;) {
    // Look up the entity before each call: a contact may change the entity, or add one and thereby
    // move all of them in memory.
    Entity& entity = world.entities[i];
    if (entity.kind != kAgentKind && Overlap(entity, world.agent(), entity.contact_margin)) {
      rules.OnAgentContact(entity);
    }
    if (world.entities[i].meets_entities) {
      MeetEntities(world, rules, i);
    }
    if (world.entities[i].smart) {
      MeetCells(world, rules, i);
    }
  }
}

void RemoveGone(World& world) {
  const auto gone = [&world](const Entity& entity) {
    return entity.marked || (entity.auto_remove && world.IsOutside(entity));
  };
  world.entities.erase(std::remove_if(world.entities.begin() + 1, world.entities.end(), gone),
                       world.entities.end());
}

}  // namespace procgen
