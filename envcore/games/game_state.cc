#include <array>

#include "absl/strings/str_cat.h"
#include "envcore/games/game.h"
#include "envcore/world/world_state.h"

namespace procgen {
namespace {

constexpr int32_t kLastMoveMax = 8;
constexpr float kStepRewardMax = 1e6F;  // either sign

}  // namespace

void Game::VisitState(StateArchive& archive, int32_t step_number_max) {
  archive.Int("step_number", step_number_, 0, step_number_max);
  const uint32_t level_seed = random_.seed();
  archive.Group("random", [&] { random_.VisitState(archive); });
  archive.Check(random_.seed() == level_seed, "has a stream that was not seeded with level_seed");
  archive.Int("last_move", last_move_, 0, kLastMoveMax);
  archive.Group("outcome", [&] {
    archive.Float("reward", outcome_.reward, -kStepRewardMax, kStepRewardMax);
    archive.Bool("done", outcome_.done);
    archive.Bool("level_complete", outcome_.level_complete);
  });
  archive.Group("world", [&] { VisitWorld(archive, world_, EntityCountMax()); });
  if (archive.ok() && archive.restores()) {
    CheckNoneBlocks(archive);
  }
  archive.Group("own", [&] { VisitOwnState(archive); });
}

bool Game::AgentIsInBlock() {
  const Entity& agent = world_.agent();
  const int kind = world_.CellAtPoint(agent.x, agent.y);
  return kind == world_.out_of_bounds_kind || Blocks(agent, kind, Axis::kHorizontal) ||
         Blocks(agent, kind, Axis::kVertical);
}

size_t Game::EntityCountMax() const { return kEntityCountMax; }

void Game::CheckNoneBlocks(StateArchive& archive) {
  std::array<bool, kKindCount> is_there = {};
  for (const Entity& entity : world_.entities) {
    is_there[static_cast<size_t>(entity.kind)] = true;
  }
  for (const Entity& mover : world_.entities) {
    for (int kind = 0; mover.smart && kind < kKindCount; ++kind) {
      const bool blocks =
          Blocks(mover, kind, Axis::kHorizontal) || Blocks(mover, kind, Axis::kVertical);
      if (is_there[static_cast<size_t>(kind)] && blocks) {
        return archive.Check(
            false, absl::StrCat("has an entity of kind ", kind, ", which only cells can have"));
      }
    }
  }
}

}  // namespace procgen
