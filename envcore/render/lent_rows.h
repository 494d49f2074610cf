#ifndef ENVCORE_RENDER_LENT_ROWS_H_
#define ENVCORE_RENDER_LENT_ROWS_H_

#include <cstdint>
#include <vector>

#include "envcore/render/frame.h"
#include "envcore/render/still_layer.h"

namespace procgen {

// Which rows of a frame are lent: they show what a still layer keeps, and their pixels in the frame
// mean nothing until something is to be drawn there. In most games that stand still little moves,
// so most rows go from the layer to the observation as they are. Threads: compatible (one thread at
// a time).
class LentRows {
 public:
  // No row is lent.
  void Clear() { layer_ = nullptr; }
  // All rows are. REQUIRES: `layer` keeps a frame of this side and stays until the next call.
  void LendAll(const StillLayer& layer, int side_px);
  // Gives the rows [first, end) their pixels, as far as they lie in the frame and are lent.
  void TakeBack(int first, int end, const Frame& frame);

  // Null: none is lent.
  const StillLayer* layer() const { return layer_; }
  bool IsLent(int row) const {
    return layer_ != nullptr && is_lent_[static_cast<size_t>(row)] != 0;
  }
  // The first row from `row` on that is not as `row` is, or the frame's side.
  int EndOfRun(int row) const;

 private:
  const StillLayer* layer_ = nullptr;
  std::vector<uint8_t> is_lent_;  // [side_px], 0 or 1; not used without a layer
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_LENT_ROWS_H_
