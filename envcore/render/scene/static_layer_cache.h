#ifndef ENVCORE_RENDER_SCENE_STATIC_LAYER_CACHE_H_
#define ENVCORE_RENDER_SCENE_STATIC_LAYER_CACHE_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/render/output/frame.h"
#include "envcore/scene/scene.h"

namespace procgen {

// The part of one environment's scenes that seldom changes: the background, the sprites below the
// cells, and the cells. With a fixed camera it is drawn once per level and then copied. The cache
// compares everything that the layer depends on, so new levels and restored states need no
// invalidation. Threads: compatible (one thread at a time).
class StaticLayerCache {
 public:
  // What to do with the static part of a scene.
  enum class Use {
    kCopy,      // the layer is cached: copy it
    kKeep,      // draw it, then call Keep: it has been the same in recent scenes
    kDrawOnly,  // draw it: it is new, or still likely to change
  };

  // Compares the next scene with the last one. REQUIRES: all scenes are drawn with one art, at one
  // size.
  Use Classify(const Scene& scene);

  // Stores the layer. REQUIRES: Classify returned kKeep; `frame` always has the same size.
  void Keep(const Frame& frame);
  // Copies the cached rows [first, end). REQUIRES: Classify returned kCopy; the rows are in the
  // frame.
  void CopyRows(int first, int end, const Frame& frame) const;
  // The cached rows as RGB: uint8 [end - first, size_px, 3].
  absl::Span<const uint8_t> Rows(int first, int end) const;

 private:
  bool Knows(const Scene& scene) const;
  void Remember(const Scene& scene);

  // The last scene. `cells.grid` is not used.
  bool met_ = false;
  Camera camera_;
  int world_width_ = 0;
  int world_height_ = 0;
  ArtStyle art_style_ = ArtStyle::kPictures;
  Background background_;
  std::vector<Sprite> below_cells_;
  bool has_cells_ = false;
  CellLayer cells_;
  int grid_width_ = 0;
  int grid_height_ = 0;
  std::vector<int16_t> kinds_;  // of the grid's cells in view, row by row

  int repeat_count_ = 0;  // number of scenes in a row with this layer, before it is cached

  int size_px_ = 0;           // of the cached layer
  std::vector<uint8_t> rgb_;  // the cached layer, in the most common format; empty: none
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_STATIC_LAYER_CACHE_H_
