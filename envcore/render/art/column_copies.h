#ifndef ENVCORE_RENDER_ART_COLUMN_COPIES_H_
#define ENVCORE_RENDER_ART_COLUMN_COPIES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "envcore/render/raster/axis_steps.h"
#include "envcore/render/raster/image.h"

namespace procgen {

// Copies of an image that contain only the columns shown by a stretched drawing, side by side. Rows
// of a large background are read from few cache lines that way. A copy is made when the same
// columns have been requested several times, and kept, up to kKeptBytesMax.
// Threads: thread-safe; takes no lock.
class ColumnCopies {
 public:
  // Number of requests after which a copy is made.
  static constexpr int kRequestsMin = 8;
  // Limit of the pixels that are kept, in bytes.
  static constexpr int64_t kKeptBytesMax = 1 << 20;

  // The part of an image that a copy contains.
  struct Part {
    int64_t position = 0;  // column i of the copy is column (position + i * step) >> 16 of the image
    int64_t step = 0;
    int width = 0;      // number of columns
    int first_row = 0;  // rows [first_row, end_row) of the image
    int end_row = 0;

    bool operator==(const Part&) const = default;
  };

  ColumnCopies() = default;
  ~ColumnCopies();
  ColumnCopies(const ColumnCopies&) = delete;
  ColumnCopies& operator=(const ColumnCopies&) = delete;

  // Returns the copy of a part of `source`, or null if there is none (yet). It lives as long as this
  // object. REQUIRES: `source` is the same in all calls; it contains the part, which is not empty.
  const Image* Find(const Image& source, const Part& part) const;

 private:
  struct Entry {
    Part part;
    Image image;
    const Entry* next = nullptr;
  };

  const Image* Make(const Image& source, const Part& part, std::atomic<const Entry*>* bucket) const;

  static constexpr size_t kBucketCount = 64;
  // Lock-free chains that only grow, at their heads.
  mutable std::array<std::atomic<const Entry*>, kBucketCount> buckets_ = {};
  // The last part that each bucket did not contain, as a hash, and the number of its requests in the
  // low byte.
  mutable std::array<std::atomic<uint64_t>, kBucketCount> missing_ = {};
  mutable std::atomic<int64_t> kept_bytes_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_COLUMN_COPIES_H_
