#include "envcore/render/scene/lent_rows.h"

namespace procgen {

void LentRows::LendAll(const StillLayer& layer, int side_px) {
  layer_ = &layer;
  lent_ = BitRange(0, side_px);
}

void LentRows::TakeBack(int first, int end, const Frame& frame) {
  const uint64_t wanted = lent_ & BitRange(first, end);
  lent_ &= ~wanted;
  ForEachBitRun(wanted, [&](int from, int to) { layer_->CopyRows(from, to, frame); });
}

}  // namespace procgen
