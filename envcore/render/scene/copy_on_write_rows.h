#ifndef ENVCORE_RENDER_SCENE_COPY_ON_WRITE_ROWS_H_
#define ENVCORE_RENDER_SCENE_COPY_ON_WRITE_ROWS_H_

#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/bit_runs.h"
#include "envcore/render/scene/static_layer_cache.h"

namespace procgen {

// Which rows of a frame are shared: they show what a static layer keeps, and their pixels in the
// frame mean nothing until something is to be drawn there. In most games that stand still little
// moves, so most rows go from the layer to the observation as they are. Threads: compatible (one
// thread at a time).
class CopyOnWriteRows {
 public:
  // The side of the largest frame whose rows can be shared.
  static constexpr int kSizePxMax = kWordBits;

  // No row is shared.
  void Clear() { shared_ = 0; }
  // All rows are. REQUIRES: `layer` keeps a frame of this side, at most kSizePxMax, and stays until
  // no row is shared.
  void ShareAll(const StaticLayerCache& layer, int size_px);
  // Gives the rows [first, end) their pixels, as far as they lie in the frame and are shared.
  void Materialize(int first, int end, const Frame& frame);

  // Which rows are shared, bit i: row i, and with which layer: null: with none so far.
  uint64_t shared() const { return shared_; }
  const StaticLayerCache* layer() const { return layer_; }

 private:
  const StaticLayerCache* layer_ = nullptr;
  uint64_t shared_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_COPY_ON_WRITE_ROWS_H_
