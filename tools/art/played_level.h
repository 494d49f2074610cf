#ifndef TOOLS_ART_PLAYED_LEVEL_H_
#define TOOLS_ART_PLAYED_LEVEL_H_

#include <cstdint>
#include <memory>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"

namespace procgen {

// A level in which somebody has got about for a while, with random actions, so that there is
// something to see: at most 100 steps, and none that ends the level. The same each time.
std::unique_ptr<Game> PlayedLevel(const GameSpec& spec, DistributionMode mode, int32_t level_seed);

}  // namespace procgen

#endif  // TOOLS_ART_PLAYED_LEVEL_H_
