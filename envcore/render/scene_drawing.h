#ifndef ENVCORE_RENDER_SCENE_DRAWING_H_
#define ENVCORE_RENDER_SCENE_DRAWING_H_

#include "envcore/render/frame.h"
#include "envcore/render/game_art.h"
#include "envcore/render/picture.h"
#include "envcore/scene/scene.h"

namespace procgen {

enum class Smoothing { kSharp, kSmooth };

// Draws `scene` in its order on `frame`: black, background, sprites below the cells, cells, sprites
// above them, velocity, overlays. `background`: null for black.
void DrawScene(const Scene& scene, const GameArt& art, const Picture* background,
               Smoothing smoothing, const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_DRAWING_H_
