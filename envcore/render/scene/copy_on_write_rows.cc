#include "envcore/render/scene/copy_on_write_rows.h"

namespace procgen {

void CopyOnWriteRows::ShareAll(const StaticLayerCache& layer, int size_px) {
  layer_ = &layer;
  shared_ = BitRange(0, size_px);
}

void CopyOnWriteRows::Materialize(int first, int end, const Frame& frame) {
  const uint64_t wanted = shared_ & BitRange(first, end);
  shared_ &= ~wanted;
  ForEachBitRun(wanted, [&](int from, int to) { layer_->CopyRows(from, to, frame); });
}

}  // namespace procgen
