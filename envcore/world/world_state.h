#ifndef ENVCORE_WORLD_WORLD_STATE_H_
#define ENVCORE_WORLD_WORLD_STATE_H_

#include <cstddef>
#include <cstdint>

#include "envcore/state/state_archive.h"
#include "envcore/world/entity.h"
#include "envcore/world/grid.h"
#include "envcore/world/world.h"

namespace procgen {

// The limits of a world in a snapshot. They are far beyond what the games reach, and small enough
// that a step of any world within them is fast and computes with finite numbers only.
inline constexpr size_t kEntityCountMax = 1024;
inline constexpr size_t kSmartEntityCountMax = 128;
inline constexpr int32_t kRememberedStepMax = 1000000;  // stored step numbers, either sign
inline constexpr float kPlaceMax = 1000;                // cells, either sign
inline constexpr float kSpeedMax = 8;                   // cells per step
inline constexpr float kHalfSizeMax = 256;              // cells

// Whether `entity` is of `kind` and will never be removed.
inline bool IsThereForGood(const Entity& entity, int kind) {
  return entity.kind == kind && !entity.marked && !entity.auto_remove && entity.expiry <= 0;
}

// Visits the state of a world that changes while a level is played: cells, entities in order,
// controls and the shared random integer. Cells are saved as runs, kind, count, kind, count ...,
// from the bottom row up. `entity_count_max`: at most kEntityCountMax; if the archive saturates,
// entities beyond it are dropped from the end.
// REQUIRES when restoring: `world` is that of a new level. The grid keeps its size.
void VisitWorld(StateArchive& archive, World& world, size_t entity_count_max = kEntityCountMax);

}  // namespace procgen

#endif  // ENVCORE_WORLD_WORLD_STATE_H_
