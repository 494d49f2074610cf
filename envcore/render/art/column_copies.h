#ifndef ENVCORE_RENDER_ART_COLUMN_COPIES_H_
#define ENVCORE_RENDER_ART_COLUMN_COPIES_H_

#include <array>
#include <atomic>
#include <cstdint>

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
    // Column i of the copy is column (position + i * step) >> 16 of the image.
    int64_t position = 0;
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

  // Returns the copy of a part of `source`, or null if there is none (yet). It lives as long as
  // this object. REQUIRES: `source` is the same in all calls; it contains the part, which is not
  // empty.
  const Image* Find(const Image& source, const Part& part) const;

 private:
  struct Entry {
    Part part;
    Image image;
    const Entry* next = nullptr;
  };

  struct Bucket {
    std::atomic<const Entry*> first = nullptr;  // a lock-free chain that only grows, at its head
    // The last part that was not found, as a hash, and the number of its requests in the low byte.
    std::atomic<uint64_t> missing = 0;
  };

  const Image* Make(const Image& source, const Part& part, Bucket* bucket) const;

  mutable std::array<Bucket, 64> buckets_;
  mutable std::atomic<int64_t> kept_bytes_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_COLUMN_COPIES_H_
