#include "tests/envcore/games/staged_game.h"

#include <algorithm>
#include <vector>

#include "envcore/state/state_archive.h"
#include "envcore/world/world_state.h"

namespace procgen {

int CountEntities(const Game& game, int kind) {
  const std::vector<Entity>& entities = game.world().entities;
  return static_cast<int>(std::count_if(entities.begin(), entities.end(),
                                        [kind](const Entity& e) { return e.kind == kind; }));
}

std::string StateOf(Game& game) {
  StateArchive archive;
  game.VisitState(archive, kRememberedStepMax);
  return archive.Finish().value();
}

}  // namespace procgen
