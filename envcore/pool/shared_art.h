#ifndef ENVCORE_POOL_SHARED_ART_H_
#define ENVCORE_POOL_SHARED_ART_H_

#include <memory>

#include "envcore/games/game_catalog.h"
#include "envcore/render/game_art.h"

namespace procgen {

// The default art of a game as all pools of the process share it: resolved when it is first asked
// for. `art`: the game's own art facts. Threads: any.
std::shared_ptr<const GameArt> SharedArt(const GameFacts& game, const GameArtFacts& art);

}  // namespace procgen

#endif  // ENVCORE_POOL_SHARED_ART_H_
