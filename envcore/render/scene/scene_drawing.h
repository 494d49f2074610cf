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

// Draws `scene` on `frame` in drawing order: black, background, sprites below the cells, cells,
// sprites above the cells, velocity, overlays. `background`: null for black.
//
// The agent's view. `cells`: kept from frame to frame. `static_layer`: of this environment; null:
// draws everything. `rows`: returns which rows are still shared with the static layer.
void DrawNearestScene(const Scene& scene, const GameArt& art, const MipmappedImage* background,
                      CellDrawing* cells, StaticLayerCache* static_layer, CopyOnWriteRows* rows,
                      const Frame& frame);
// The human view.
void DrawAntialiasedScene(const Scene& scene, const GameArt& art, const MipmappedImage* background,
                          const Frame& frame);

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_SCENE_DRAWING_H_
