#ifndef SERVER_FLEET_PICTURE_COUNT_H_
#define SERVER_FLEET_PICTURE_COUNT_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/session/request.h"

namespace procgen {

// Whether what environments have shown since a moment is enough to draw their observations anew:
// where these are stacks of k pictures, each environment must have added k - 1, or have begun an
// episode. A snapshot holds no pictures, so it is of use only from then on.
// Threads: compatible.
class PictureCount {
 public:
  PictureCount(Part range, int32_t frame_stack)
      : range_(range), needed_(frame_stack - 1), counts_(static_cast<size_t>(range.count)) {}

  // Begins with this moment.
  void Clear() { std::fill(counts_.begin(), counts_.end(), 0); }
  // Environments of `slice` were stepped.
  void AddStep(Part slice) {
    const int32_t end = std::min(slice.first + slice.count, range_.first + range_.count);
    for (int32_t i = std::max(slice.first, range_.first); i < end; ++i) {
      ++counts_[static_cast<size_t>(i - range_.first)];
    }
  }
  bool IsComplete() const {
    return std::all_of(counts_.begin(), counts_.end(),
                       [this](int32_t count) { return count >= needed_; });
  }

 private:
  Part range_;
  int32_t needed_;
  std::vector<int32_t> counts_;  // pictures added since, by environment
};

}  // namespace procgen

#endif  // SERVER_FLEET_PICTURE_COUNT_H_
