#ifndef ENVCORE_RENDER_SCENE_SCENE_DRAWING_H_
#define ENVCORE_RENDER_SCENE_SCENE_DRAWING_H_

#include "envcore/render/art/game_art.h"
#include "envcore/render/art/mipmapped_image.h"
#include "envcore/render/output/frame.h"
#include "envcore/render/scene/cell_drawing.h"
#include "envcore/render/scene/copy_on_write_rows.h"
#include "envcore/render/scene/static_layer_cache.h"
#include "envcore/scene/scene.h"

namespace procgen {

// Draws `scene` in its order on `frame`: black, background, sprites below the cells, cells, sprites
// above them, velocity, overlays. `background`: null for black.
//
// As the agent sees it. `cells`: kept from frame to frame. `static_layer`: of this environment;
// null: all is drawn. `rows`: tells which rows are shared with it in the end.
void DrawNearestScene(const Scene& scene, const GameArt& art, const MipmappedImage* background,
                      CellDrawing* cells, StaticLayerCache* static_layer, CopyOnWriteRows* rows,
                      const Frame& frame);
// For the eye.
void DrawAntialiasedScene(const Scene& scene, const GameArt& art, const MipmappedImage* background,
                          const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_SCENE_DRAWING_H_
