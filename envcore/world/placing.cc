#include "envcore/world/placing.h"

#include <algorithm>
#include <cmath>

namespace procgen {
namespace {

constexpr int kAttemptsMax = 100;

constexpr double kDustDepth = 0.5;    // below the parent's center, in the parent's half-heights
constexpr float kDustSpeed = 0.01F;   // cells per step, upward
constexpr float kDustRadiusX = 0.3F;  // cells, initial value
constexpr float kDustRadiusY = 0.2F;
constexpr float kDustOpacity = 0.5F;
constexpr int kDustLifeSteps = 8;

bool Collides(const World& world, const Entity& entity, CollisionCheck check) {
  if (Overlap(entity, world.agent(), 0)) {
    return true;
  }
  return check == CollisionCheck::kAll &&
         std::any_of(world.entities.begin(), world.entities.end(), [&entity](const Entity& other) {
           return !other.avoids_collisions && Overlap(entity, other, 0);
         });
}

}  // namespace

float DrawCenter(RandomStream& random, float low, float high, float radius) {
  if (high - low <= 2 * radius) {
    return (high + low) / 2;
  }
  return ((high - low) - 2 * radius) * random.Unit() + radius + low;
}

Entity& SpawnInBox(World& world, RandomStream& random, int kind, float rx, float ry, const Box& box,
                   CollisionCheck check) {
  Entity entity = Entity::Make(kind, 0, 0, 0, 0, rx, ry);
  entity.x = DrawCenter(random, box.x, box.x + box.width, rx);
  entity.y = DrawCenter(random, box.y, box.y + box.height, ry);
  for (int attempt = 0; attempt < kAttemptsMax && Collides(world, entity, check); ++attempt) {
    entity.x = DrawCenter(random, box.x, box.x + box.width, rx);
    entity.y = DrawCenter(random, box.y, box.y + box.height, ry);
  }
  return world.entities.emplace_back(entity);
}

Entity& SpawnAtCell(World& world, int kind, float radius, int cell_index) {
  const int row = cell_index / world.grid.width();
  const float x = static_cast<float>(cell_index % world.grid.width()) + 0.5F;
  const float y = static_cast<float>(row) + 0.5F;
  return world.entities.emplace_back(Entity::Make(kind, x, y, 0, 0, radius, radius));
}

Entity& SpawnChild(World& world, int kind, float radius, const Entity& parent,
                   bool keeps_velocity) {
  const float vx = keeps_velocity ? parent.vx : 0;
  const float vy = keeps_velocity ? parent.vy : 0;
  return world.entities.emplace_back(
      Entity::Make(kind, parent.x, parent.y, vx, vy, radius, radius));
}

bool OverlapsAnything(const World& world, const Entity& entity) {
  return std::any_of(world.entities.begin(), world.entities.end(),
                     [&entity](const Entity& other) { return Overlap(entity, other, 0); });
}

Entity& SpawnDust(World& world, const Entity& parent) {
  const auto y = static_cast<float>(parent.y - parent.ry * kDustDepth);
  Entity& dust = world.entities.emplace_back(
      Entity::Make(kTrailKind, parent.x, y, 0, kDustSpeed, kDustRadiusX, kDustRadiusY));
  dust.expiry = kDustLifeSteps;
  dust.opacity = kDustOpacity;
  return dust;
}

void PlaceAgentAtRandom(World& world, RandomStream& random) {
  Entity& agent = world.agent();
  const auto collides = [&world, &agent] {
    return std::any_of(
        world.entities.begin() + 1, world.entities.end(),
        [&agent](const Entity& other) { return Overlap(agent, other, other.contact_margin); });
  };
  for (int attempt = 0; attempt < kAttemptsMax; ++attempt) {
    agent.x = random.Unit() * (static_cast<float>(world.grid.width()) - 2 * agent.rx) + agent.rx;
    agent.y = random.Unit() * (static_cast<float>(world.grid.height()) - 2 * agent.ry) + agent.ry;
    if (!collides()) {
      return;
    }
  }
}

float Distance(const Entity& a, const Entity& b) {
  const float dx = a.x - b.x;
  const float dy = a.y - b.y;
  return std::sqrt(dx * dx + dy * dy);
}

}  // namespace procgen
