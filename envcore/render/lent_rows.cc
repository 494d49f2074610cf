#include "envcore/render/lent_rows.h"

#include <algorithm>
#include <cstddef>

namespace procgen {

void LentRows::LendAll(const StillLayer& layer, int side_px) {
  layer_ = &layer;
  is_lent_.assign(static_cast<size_t>(side_px), 1);
}

void LentRows::TakeBack(int first, int end, const Frame& frame) {
  if (layer_ == nullptr) {
    return;
  }
  end = std::min(end, frame.side_px);
  for (int row = std::max(first, 0); row < end;) {
    const int run_end = std::min(EndOfRun(row), end);
    if (IsLent(row)) {
      layer_->CopyRows(row, run_end, frame);
      std::fill(is_lent_.begin() + row, is_lent_.begin() + run_end, uint8_t{0});
    }
    row = run_end;
  }
}

int LentRows::EndOfRun(int row) const {
  const auto from = is_lent_.begin() + row;
  return static_cast<int>(std::find(from, is_lent_.end(), *from == 0 ? 1 : 0) - is_lent_.begin());
}

}  // namespace procgen
