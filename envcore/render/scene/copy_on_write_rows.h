#ifndef ENVCORE_RENDER_SCENE_COPY_ON_WRITE_ROWS_H_
#define ENVCORE_RENDER_SCENE_COPY_ON_WRITE_ROWS_H_

#include <cstdint>

#include "envcore/render/output/frame.h"
#include "envcore/render/raster/bit_runs.h"
#include "envcore/render/scene/static_layer_cache.h"

namespace procgen {

// The rows of a frame that are shared with a static layer. A shared row has no valid pixels in the
// frame until something is drawn on it. In most games with a fixed camera little moves, so most
// rows are copied from the layer to the observation directly. Threads: compatible (one thread at a
// time).
class CopyOnWriteRows {
 public:
  // Size of the largest frame whose rows can be shared.
  static constexpr int kSizePxMax = kWordBits;

  // Marks no row as shared.
  void Clear() { shared_ = 0; }
  // Marks all rows as shared. REQUIRES: `layer` holds a frame of this size, at most kSizePxMax, and
  // lives until no row is shared.
  void ShareAll(const StaticLayerCache& layer, int size_px);
  // Copies the pixels of those rows of [first, end) that are shared, so that they can be drawn on.
  void Materialize(int first, int end, const Frame& frame);

  // The shared rows, bit i for row i, and the layer that they are shared with (null: none yet).
  uint64_t shared() const { return shared_; }
  const StaticLayerCache* layer() const { return layer_; }

 private:
  const StaticLayerCache* layer_ = nullptr;
  uint64_t shared_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_SCENE_COPY_ON_WRITE_ROWS_H_
