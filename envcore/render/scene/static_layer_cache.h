#ifndef ENVCORE_RENDER_SCENE_STATIC_LAYER_CACHE_H_
#define ENVCORE_RENDER_SCENE_STATIC_LAYER_CACHE_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/render/output/frame.h"
#include "envcore/scene/scene.h"

namespace procgen {

// What one environment's scenes have shown of what seldom moves: the background, the sprites below
// the cells, and the cells. Where the camera stands still, it is drawn once a level and
// copied after that. It is known again by all that it depends on, so nobody need tell it of new
// levels or restored states. Threads: compatible (one thread at a time).
class StaticLayerCache {
 public:
  // What to do with the static part of a scene.
  enum class Use {
    kCopy,      // it is kept: take it from here
    kKeep,      // draw it and Keep it: it was the same in the scenes before
    kDrawOnly,  // draw it: it is new, or not known for long, and may move on
  };

  // Looks at the next scene. REQUIRES: the scenes are all drawn with the same art, at one size.
  Use Meet(const Scene& scene);

  // REQUIRES: Meet said so; `frame` has always the same size.
  void Keep(const Frame& frame);
  // The kept pixels of the rows [first, end). REQUIRES: Meet said kCopy; the rows lie in the frame.
  void CopyRows(int first, int end, const Frame& frame) const;
  // The same as red, green, blue: uint8 [end - first, size_px, 3].
  absl::Span<const uint8_t> Rows(int first, int end) const;

 private:
  bool Knows(const Scene& scene) const;
  void Remember(const Scene& scene);

  // What was met last. `cells.grid` is not used.
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

  int repeat_count_ = 0;  // scenes that met it again and did not find it kept

  int size_px_ = 0;           // of what is kept
  std::vector<uint8_t> rgb_;  // what is kept, packed as most observations are; empty: nothing
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_STATIC_LAYER_CACHE_H_
