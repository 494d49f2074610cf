#include "envcore/world/direction.h"

#include <cmath>

namespace procgen {

void TurnTo(Entity& entity, float dx, float dy, float offset) {
  if (dx != 0 || dy != 0) {
    entity.rotation = -std::atan2(dy, dx) + offset;  // atan2 in f32
  }
}

}  // namespace procgen
