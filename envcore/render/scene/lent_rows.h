#ifndef ENVCORE_RENDER_SCENE_LENT_ROWS_H_
#define ENVCORE_RENDER_SCENE_LENT_ROWS_H_

#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/bit_runs.h"
#include "envcore/render/scene/still_layer.h"

namespace procgen {

// Which rows of a frame are lent: they show what a still layer keeps, and their pixels in the frame
// mean nothing until something is to be drawn there. In most games that stand still little moves,
// so most rows go from the layer to the observation as they are. Threads: compatible (one thread at
// a time).
class LentRows {
 public:
  // The side of the largest frame whose rows can be lent.
  static constexpr int kSidePxMax = kWordBits;

  // No row is lent.
  void Clear() { lent_ = 0; }
  // All rows are. REQUIRES: `layer` keeps a frame of this side, at most kSidePxMax, and stays until
  // no row is lent.
  void LendAll(const StillLayer& layer, int side_px);
  // Gives the rows [first, end) their pixels, as far as they lie in the frame and are lent.
  void TakeBack(int first, int end, const Frame& frame);

  // Which rows are lent, bit i: row i, and by whom: null: by nobody so far.
  uint64_t lent() const { return lent_; }
  const StillLayer* layer() const { return layer_; }

 private:
  const StillLayer* layer_ = nullptr;
  uint64_t lent_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_LENT_ROWS_H_
