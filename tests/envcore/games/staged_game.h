#ifndef TESTS_ENVCORE_GAMES_STAGED_GAME_H_
#define TESTS_ENVCORE_GAMES_STAGED_GAME_H_

#include <cstdint>
#include <memory>
#include <string>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "gtest/gtest.h"
#include "tests/envcore/world/drawn_world.h"

namespace procgen {

// A game of the catalog at the first step of a level.
inline std::unique_ptr<Game> StartedGame(const std::string& name, int32_t level_seed,
                                         const GameOptions& options = {}) {
  const GameSpec* spec = FindGame(name);
  std::unique_ptr<Game> game = spec->make(options);
  game->StartLevel(level_seed);
  return game;
}

// Mutable access to the world of a game, to set up situations that are rare in levels.
inline World& Stage(Game& game) { return const_cast<World&>(game.world()); }

// Puts the agent at rest at (x, y), alone in an otherwise empty world of the game's size.
inline void StageAgentAlone(Game& game, float x, float y) {
  World& world = Stage(game);
  world.grid.Reset(world.grid.width(), world.grid.height(), kEmptyKind);
  world.entities.resize(1);
  world.agent().x = x;
  world.agent().y = y;
  world.agent().vx = 0;
  world.agent().vy = 0;
}

// The number of entities of `kind`.
int CountEntities(const Game& game, int kind);

// The state as in a snapshot, with the outcome of the last step.
std::string StateOf(Game& game);

}  // namespace procgen

#endif  // TESTS_ENVCORE_GAMES_STAGED_GAME_H_
