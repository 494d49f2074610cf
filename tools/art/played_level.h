#ifndef TOOLS_ART_PLAYED_LEVEL_H_
#define TOOLS_ART_PLAYED_LEVEL_H_

#include <cstdint>
#include <memory>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"

namespace procgen {

// Returns a level after up to 100 steps with random actions, so that it shows more than its start.
// No step ends the level. Equal arguments give equal levels.
std::unique_ptr<Game> PlayedLevel(const GameSpec& spec, DistributionMode mode, int32_t level_seed);

}  // namespace procgen

#endif  // TOOLS_ART_PLAYED_LEVEL_H_
