#ifndef TOOLS_ART_BACKDROPS_H_
#define TOOLS_ART_BACKDROPS_H_

#include <memory>
#include <string>
#include <vector>

#include "envcore/games/game.h"
#include "envcore/games/game_catalog.h"
#include "envcore/render/art/game_art.h"
#include "tools/art/legibility.h"
#include "tools/art/roles.h"

namespace procgen {

// A game at the start of a level, for its camera, world and backgrounds.
std::unique_ptr<Game> StageOf(const Roles& roles);

// A background or a tiled surface that parts are seen on.
struct Backdrop {
  int image_kind = kBackgroundBackdrop;
  std::string name;             // "background 12", "image kind 2 theme 0"
  std::vector<Window> windows;  // samples from several places
};

// Returns the backdrops of a game: every image of its background group, and each image kind that
// parts are seen on, in all its themes.
std::vector<Backdrop> BackdropsOf(const Roles& roles, const Game& stage, const GameArt& art);

// The number of themes of an image kind in a game, at least 1.
int ThemeCountOf(const Game& stage, int image_kind);

}  // namespace procgen

#endif  // TOOLS_ART_BACKDROPS_H_
