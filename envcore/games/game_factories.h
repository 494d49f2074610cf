#ifndef ENVCORE_GAMES_GAME_FACTORIES_H_
#define ENVCORE_GAMES_GAME_FACTORIES_H_

#include <memory>

#include "envcore/games/game.h"
#include "envcore/games/game_options.h"

namespace procgen {

// The factories of the games, defined in <game>.cc and called through the catalog. REQUIRES: the
// game has `options.distribution_mode`.
std::unique_ptr<Game> MakeBigFish(const GameOptions& options);
std::unique_ptr<Game> MakeBossFight(const GameOptions& options);
std::unique_ptr<Game> MakeCaveFlyer(const GameOptions& options);
std::unique_ptr<Game> MakeChaser(const GameOptions& options);
std::unique_ptr<Game> MakeClimber(const GameOptions& options);
std::unique_ptr<Game> MakeCoinRun(const GameOptions& options);
std::unique_ptr<Game> MakeDodgeball(const GameOptions& options);
std::unique_ptr<Game> MakeFruitBot(const GameOptions& options);
std::unique_ptr<Game> MakeHeist(const GameOptions& options);
std::unique_ptr<Game> MakeJumper(const GameOptions& options);
std::unique_ptr<Game> MakeLeaper(const GameOptions& options);
std::unique_ptr<Game> MakeMaze(const GameOptions& options);
std::unique_ptr<Game> MakeMiner(const GameOptions& options);
std::unique_ptr<Game> MakeNinja(const GameOptions& options);
std::unique_ptr<Game> MakePlunder(const GameOptions& options);
std::unique_ptr<Game> MakeStarPilot(const GameOptions& options);

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_FACTORIES_H_
