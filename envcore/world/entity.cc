#include "envcore/world/entity.h"

#include <cmath>

#include "envcore/world/kinds.h"

namespace procgen {

Entity Entity::Make(int kind, float x, float y, float vx, float vy, float rx, float ry) {
  Entity entity;
  entity.x = x;
  entity.y = y;
  entity.vx = vx;
  entity.vy = vy;
  entity.rx = rx;
  entity.ry = ry;
  entity.kind = kind;
  entity.image_kind = kind;
  if (kind == kExplosionKind) {
    entity.growth = 1.4F;
    entity.expiry = 4;
  } else if (kind == kTrailKind) {
    entity.growth = 1.05F;
    entity.fading = 0.8F;
  }
  return entity;
}

void Entity::Step() {
  if (!smart) {
    x += vx;
    y += vy;
  }
  rotation += spin;
  vx *= friction;
  vy *= friction;
  ++life_time;
  if (expiry > 0 && life_time > expiry) {
    marked = true;
  }
  if (kind == kExplosionKind && image_kind < kLastExplosionKind) {
    ++image_kind;
  }
  rx *= growth;
  ry *= growth;
  opacity = fading * opacity;
}

}  // namespace procgen
