#ifndef ENVCORE_RENDER_ART_SCALED_IMAGE_CACHE_H_
#define ENVCORE_RENDER_ART_SCALED_IMAGE_CACHE_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "envcore/render/raster/image.h"

namespace procgen {

// Rotated pictures are kept for this many angles in a full turn.
inline constexpr int kAngleCount = 64;

// An image of exactly the size that it is drawn at.
struct ScaledImage {
  Image image;
  bool opaque = false;  // every pixel is
};

// The size and angle of a picture on the screen.
struct ScaledSize {
  int width = 0;  // pixels, before it is rotated
  int height = 0;
  int angle = 0;  // clockwise, in [0, kAngleCount) parts of a full turn

  bool operator==(const ScaledSize&) const = default;
};

// A picture that lives at least as long as something else does: costs nothing to hold.
inline std::shared_ptr<const ScaledImage> Unowned(const ScaledImage& picture) {
  return {std::shared_ptr<const ScaledImage>(), &picture};
}

// `source` at another size, each pixel the mean of the area that it stands for, rounded. A rotated
// one is as large as its corners need. REQUIRES: width, height > 0; the source is not empty.
Image Scaled(const Image& source, const ScaledSize& size);

// The sizes and angles that one picture has been drawn at, each made once and kept, up to a number
// of bytes: enough for some dozens of sizes of a sprite at all its angles, and for a background in
// the worlds of all games. Those beyond, which only pools of many different observation sizes ask
// for, are made anew for each use. Threads: any method from any thread; what is kept is never
// locked.
class ScaledImageCache {
 public:
  // Sprites and cells that are larger are not kept.
  static constexpr int kSizePxMax = 32;
  // Of pixels, that are kept.
  static constexpr int64_t kKeptBytesMax = 4 << 20;

  ScaledImageCache() = default;
  ~ScaledImageCache();
  ScaledImageCache(const ScaledImageCache&) = delete;
  ScaledImageCache& operator=(const ScaledImageCache&) = delete;

  // The picture at a size; null: it is not kept. What is returned lives as long as this.
  const ScaledImage* Find(const ScaledSize& size) const;
  // Whether a picture that is not rotated could be kept now.
  bool HasRoomFor(const ScaledSize& size) const;
  // Makes it from `source`, unless another thread was faster. What is returned is either kept, and
  // lives as long as this, or the caller's.
  std::shared_ptr<const ScaledImage> Make(const Image& source, const ScaledSize& size) const;

 private:
  struct Entry {
    ScaledSize size;
    ScaledImage picture;
    const Entry* next = nullptr;
  };
  using Bucket = std::atomic<const Entry*>;

  Bucket& BucketOf(const ScaledSize& size) const;
  static const Entry* FindIn(const Entry* first, const Entry* end, const ScaledSize& size);

  // Chains that only grow, at their heads.
  mutable std::array<Bucket, 64> buckets_ = {};
  mutable std::atomic<int64_t> kept_bytes_ = 0;
};

}  // namespace procgen

#endif  // ENVCORE_RENDER_ART_SCALED_IMAGE_CACHE_H_
