#include "envcore/world/world_state.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/world/kinds.h"

namespace procgen {
namespace {

constexpr int32_t kSharedRandomMax = 999999;
constexpr float kAngleMax = 1e6F;       // radians, either sign
constexpr float kSpinMax = 16;          // radians per step
constexpr int32_t kCellKindMax = 1100;  // cells have kinds that entities do not have
constexpr float kHealthMax = 1e6F;      // either sign
constexpr float kGrowthMax = 1.5F;      // only for entities that expire
constexpr int32_t kGrowingStepsMax = 32;
constexpr float kMoverHalfSizeMax = 8;  // of smart entities, which must fit into their world

// Runs of equal cells: kind, count, kind, count ...
std::vector<int32_t> RunsOf(const Grid& grid) {
  std::vector<int32_t> runs;
  for (int cell = 0; cell < grid.size(); ++cell) {
    const int kind = grid.At(cell);
    if (runs.empty() || runs[runs.size() - 2] != kind) {
      runs.push_back(kind);
      runs.push_back(0);
    }
    ++runs.back();
  }
  return runs;
}

// Fills `grid` from `runs`. Returns false unless they are valid kinds and counts that fill it
// exactly.
bool Fill(const std::vector<int32_t>& runs, Grid& grid) {
  int cell = 0;
  for (size_t i = 0; i + 1 < runs.size(); i += 2) {
    const int kind = runs[i];
    const int count = runs[i + 1];
    if (kind > kCellKindMax || count < 1 || count > grid.size() - cell) {
      return false;
    }
    for (int end = cell + count; cell < end; ++cell) {
      grid.Set(cell, kind);
    }
  }
  return runs.size() % 2 == 0 && cell == grid.size();
}

void VisitGrid(StateArchive& archive, Grid& grid) {
  std::vector<int32_t> runs;
  if (!archive.restores()) {
    runs = RunsOf(grid);
  }
  archive.Ints("cells", runs, 2 * static_cast<size_t>(grid.size()), 0,
               std::max(grid.size(), kCellKindMax));
  if (archive.ok() && archive.restores()) {
    archive.Check(Fill(runs, grid),
                  "has cells that are not runs of a kind in [0, 1100] and a count "
                  "that fill the world");
  }
}

// An entity that grows must expire soon, and a smart one must not grow.
bool MayGrow(const Entity& entity) {
  return entity.expiry > 0 && entity.expiry <= kGrowingStepsMax && !entity.smart;
}

// Most fields are omitted when they have the value of a default entity.
void VisitEntity(StateArchive& archive, Entity& entity) {
  const Entity plain;
  // While restoring, the other fields are not known yet. The checks at the end cover that case.
  const bool is_known = !archive.restores();
  const float half_size_max = is_known && entity.smart ? kMoverHalfSizeMax : kHalfSizeMax;
  const float growth_max = is_known && !MayGrow(entity) ? plain.growth : kGrowthMax;
  archive.Int("kind", entity.kind, 0, kKindCount - 1);
  archive.Float("x", entity.x, -kPlaceMax, kPlaceMax);
  archive.Float("y", entity.y, -kPlaceMax, kPlaceMax);
  archive.Float("vx", entity.vx, -kSpeedMax, kSpeedMax, plain.vx);
  archive.Float("vy", entity.vy, -kSpeedMax, kSpeedMax, plain.vy);
  archive.Float("rx", entity.rx, 0, half_size_max);
  archive.Float("ry", entity.ry, 0, half_size_max);
  archive.Int("image_kind", entity.image_kind, 1 - kKindCount, kKindCount - 1);
  archive.Int("theme", entity.theme, 0, kKindCount - 1, plain.theme);
  archive.Int("layer", entity.layer, -1, 2, plain.layer);
  archive.Bool("marked", entity.marked, plain.marked);
  archive.Bool("meets_entities", entity.meets_entities, plain.meets_entities);
  archive.Float("contact_margin", entity.contact_margin, 0, 1, plain.contact_margin);
  archive.Float("rotation", entity.rotation, -kAngleMax, kAngleMax, plain.rotation);
  archive.Float("spin", entity.spin, -kSpinMax, kSpinMax, plain.spin);
  archive.Bool("mirrored", entity.mirrored, plain.mirrored);
  archive.Int("shot_step", entity.shot_step, -kRememberedStepMax, kRememberedStepMax,
              plain.shot_step);
  archive.Int("spawn_step", entity.spawn_step, -kRememberedStepMax, kRememberedStepMax,
              plain.spawn_step);
  archive.Int("life_time", entity.life_time, 0, kRememberedStepMax, plain.life_time);
  archive.Int("expiry", entity.expiry, -1, kRememberedStepMax, plain.expiry);
  archive.Bool("screen_coordinates", entity.screen_coordinates, plain.screen_coordinates);
  archive.Float("friction", entity.friction, 0, 1, plain.friction);
  archive.Bool("smart", entity.smart, plain.smart);
  archive.Bool("avoids_collisions", entity.avoids_collisions, plain.avoids_collisions);
  archive.Bool("auto_remove", entity.auto_remove, plain.auto_remove);
  archive.Float("opacity", entity.opacity, 0, 1, plain.opacity);
  archive.Float("health", entity.health, -kHealthMax, kHealthMax, plain.health);
  archive.Float("angle", entity.angle, -kAngleMax, kAngleMax, plain.angle);
  archive.Float("growth", entity.growth, 0, growth_max, plain.growth);
  archive.Float("fading", entity.fading, 0, 1, plain.fading);
  archive.Float("patrol_center", entity.patrol_center, -kPlaceMax, kPlaceMax, plain.patrol_center);
  archive.Check(!entity.smart || (entity.rx <= kMoverHalfSizeMax && entity.ry <= kMoverHalfSizeMax),
                "is smart and larger than 16 cells");
  archive.Check(entity.growth <= plain.growth || MayGrow(entity),
                "grows, but only entities that expire within 32 steps and are not smart can grow");
}

// Drops entities from the end until the limits of all and of smart entities hold.
void DropLastEntities(size_t entity_count_max, std::vector<Entity>* entities) {
  size_t smart_count = 0;
  size_t kept_count = 0;
  while (kept_count < std::min(entities->size(), entity_count_max)) {
    smart_count += (*entities)[kept_count].smart ? 1 : 0;
    if (smart_count > kSmartEntityCountMax) {
      break;
    }
    ++kept_count;
  }
  entities->resize(kept_count);
}

}  // namespace

void VisitWorld(StateArchive& archive, World& world, size_t entity_count_max) {
  if (archive.saturates()) {
    DropLastEntities(entity_count_max, &world.entities);
  }
  archive.Int("shared_random", world.shared_random, 0, kSharedRandomMax);
  archive.Group("controls", [&] {
    archive.Float("horizontal", world.controls.horizontal, -1, 1);
    archive.Float("vertical", world.controls.vertical, -1, 1);
    archive.Float("turn", world.controls.turn, -1, 1);
  });
  VisitGrid(archive, world.grid);
  archive.Groups<Entity>("entities", world.entities, 1, entity_count_max,
                         [&archive](Entity& entity) { VisitEntity(archive, entity); });
  if (!archive.ok()) {
    return;
  }
  archive.Check(world.agent().kind == kAgentKind && world.agent().smart,
                "has a first entity that is not the agent (of kind 0, and smart)");
  const auto smart_count = std::count_if(world.entities.begin(), world.entities.end(),
                                         [](const Entity& entity) { return entity.smart; });
  archive.Check(smart_count <= static_cast<std::ptrdiff_t>(kSmartEntityCountMax),
                absl::StrCat("has more than ", kSmartEntityCountMax, " smart entities"));
}

}  // namespace procgen
