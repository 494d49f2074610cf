#include "tests/envcore/games/staged_game.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <vector>

namespace procgen {
namespace {

// 64-bit FNV-1a.
class Digest {
 public:
  template <typename T>
  void Add(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    for (const unsigned char byte : bytes) {
      hash_ = (hash_ ^ byte) * 1099511628211U;
    }
  }
  uint64_t hash() const { return hash_; }

 private:
  uint64_t hash_ = 14695981039346656037U;
};

void AddEntity(const Entity& entity, Digest* digest) {
  for (const float value :
       {entity.x, entity.y, entity.vx, entity.vy, entity.rx, entity.ry, entity.contact_margin,
        entity.rotation, entity.spin, entity.friction, entity.opacity, entity.health, entity.angle,
        entity.growth, entity.fading, entity.patrol_center}) {
    digest->Add(value);
  }
  for (const int value : {entity.kind, entity.image_kind, entity.theme, entity.layer,
                          entity.shot_step, entity.spawn_step, entity.life_time, entity.expiry}) {
    digest->Add(value);
  }
  for (const bool value :
       {entity.marked, entity.meets_entities, entity.mirrored, entity.screen_coordinates,
        entity.smart, entity.avoids_collisions, entity.auto_remove}) {
    digest->Add(value);
  }
}

}  // namespace

int CountEntities(const Game& game, int kind) {
  const std::vector<Entity>& entities = game.world().entities;
  return static_cast<int>(std::count_if(entities.begin(), entities.end(),
                                        [kind](const Entity& e) { return e.kind == kind; }));
}

uint64_t DigestOf(const Game& game) {
  Digest digest;
  digest.Add(game.step_number());
  digest.Add(game.random().seed());
  digest.Add(game.random().draws());
  digest.Add(game.outcome().reward);
  digest.Add(game.outcome().done);
  digest.Add(game.outcome().level_complete);
  const World& world = game.world();
  digest.Add(world.out_of_bounds_kind);
  digest.Add(world.whole_cell_motion);
  digest.Add(world.shared_random);
  digest.Add(world.controls.horizontal);
  digest.Add(world.controls.vertical);
  digest.Add(world.controls.turn);
  for (const Entity& entity : world.entities) {
    AddEntity(entity, &digest);
  }
  digest.Add(world.grid.width());
  for (int cell = 0; cell < world.grid.size(); ++cell) {
    digest.Add(world.grid.At(cell));
  }
  return digest.hash();
}

}  // namespace procgen
