#ifndef ENVCORE_WORLD_WORLD_STATE_H_
#define ENVCORE_WORLD_WORLD_STATE_H_

#include <cstddef>
#include <cstdint>

#include "envcore/state/state_archive.h"
#include "envcore/world/entity.h"
#include "envcore/world/grid.h"
#include "envcore/world/world.h"

namespace procgen {

// The bounds of a world in a snapshot. They are far beyond what the games reach, and near enough
// that a step of any world within them is quick and computes with finite numbers only.
inline constexpr size_t kEntityCountMax = 1024;
inline constexpr size_t kSmartEntityCountMax = 128;
inline constexpr int32_t kRememberedStepMax = 1000000;  // of steps in games' memories, either sign
inline constexpr float kPlaceMax = 1000;                // cells, either sign
inline constexpr float kSpeedMax = 8;                   // cells a step
inline constexpr float kHalfSizeMax = 256;              // cells

// Whether `entity` is of `kind` and will never be removed.
inline bool IsThereForGood(const Entity& entity, int kind) {
  return entity.kind == kind && !entity.marked && !entity.auto_remove && entity.expiry <= 0;
}

// What changes of a world while a level is played: cells, entities in their order, controls and
// the shared random integer. Cells are saved in runs: kind, count, kind, count ... from the bottom
// row up. While restoring, `world` is a new level's and the grid keeps its size.
// At most `entity_count_max` entities, which is at most kEntityCountMax. Where the archive
// saturates, the last entities go if there are too many.
void VisitWorld(StateArchive& archive, World& world, size_t entity_count_max = kEntityCountMax);

}  // namespace procgen

#endif  // ENVCORE_WORLD_WORLD_STATE_H_
