#ifndef ENVCORE_RENDER_GAME_ART_H_
#define ENVCORE_RENDER_GAME_ART_H_

namespace procgen {

// Everything that one game can show. Empty while only flat colours are drawn.
class GameArt {};

}  // namespace procgen

#endif  // ENVCORE_RENDER_GAME_ART_H_
